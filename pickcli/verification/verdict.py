"""The verdict: what the verifier answers."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.errors import Reason
from pickcli.motion.plan import Certificate


@dataclass(frozen=True)
class Verdict:
    """Either a certificate and no reasons, or no certificate and every reason that was found.

    Attributes:
        certificate: What was checked, or None.
        reasons: Faults.
    """

    certificate: Certificate | None
    reasons: tuple[Reason, ...]
