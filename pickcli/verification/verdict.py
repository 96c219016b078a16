"""The verdict: result of a verification."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.errors import Reason
from pickcli.motion.plan import Certificate


@dataclass(frozen=True)
class Verdict:
    """Either a certificate and no reasons, or no certificate and all reasons found.

    Attributes:
        certificate: Certificate of the checks, or None.
        reasons: Faults.
    """

    certificate: Certificate | None
    reasons: tuple[Reason, ...]
