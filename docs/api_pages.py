"""Sphinx extension: one page of Python reference for each package, from its docstrings."""

from __future__ import annotations

import re
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.domains.python import ObjectEntry, PythonDomain
from sphinx.environment import BuildEnvironment

PACKAGE = Path(__file__).parents[1] / "pickcli"
FOLDER = Path("reference") / "api"


def modules_of(package: Path) -> list[str]:
    """Dotted names of a package and its public modules, then those of the folders in it."""
    name = ".".join([PACKAGE.name, *package.relative_to(PACKAGE).parts])
    own = [name, *(f"{name}.{path.stem}" for path in sorted(package.glob("[a-z]*.py")))]
    folders = sorted(path.parent for path in package.glob("*/__init__.py"))
    return [*own, *(module for folder in folders for module in modules_of(folder))]


def page(package: Path) -> str:
    """The Markdown of a package's page."""
    lines = [f"# {package.name}", ""]
    for module in modules_of(package):
        title = [] if module.count(".") == 1 else [f"## {module}", ""]
        lines += [*title, "```{eval-rst}", f".. automodule:: {module}", "```", ""]
    return "\n".join(lines)


def write_pages(app: Sphinx) -> None:
    """Write the pages of all packages, those of the last build that changed."""
    folder = Path(app.srcdir) / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    packages = sorted(path.parent for path in PACKAGE.glob("*/__init__.py"))
    wanted = {folder / f"{package.name}.md": page(package) for package in packages}
    for old in set(folder.glob("*.md")) - set(wanted):
        old.unlink()
    for path, text in wanted.items():
        if not path.is_file() or path.read_text() != text:
            path.write_text(text)


SECTIONS = re.compile(r"(Args|Attributes|Example|Examples|Note|Raises|Returns|Yields):$")


def plain(line: str) -> str:
    """A line in which names in backticks are code; bars, stars and underscores are not markup."""
    line = re.sub(r"(?<![`:\w])`([^`]+)`(?!`)", r"``\1``", line)
    parts = re.split(r"(``.*?``|:[\w:]+:`.*?`)", line)
    parts[::2] = [re.sub(r"([|*_`])", r"\\\1", part) for part in parts[::2]]
    return "".join(parts)


def prepare(app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Turn a docstring into text that reStructuredText reads as it is meant.

    Markup characters are escaped, indented paragraphs become literal, and hanging indents go.
    """
    out: list[str] = []
    mode = "text"
    for line in lines:
        if line and not line.startswith(" "):
            mode = "section" if SECTIONS.match(line) else "text"
        elif line.startswith("    ") and mode == "text":
            if out and not out[-1]:
                out += ["::", ""]
                mode = "literal"
            else:
                line = line.strip()
        out.append(line if mode == "literal" else plain(line))
    lines[:] = out


class IndexedPython(PythonDomain):
    """The domain of Python, which does not search all objects for names such as `float` that none has."""

    def find_obj(
        self, env: BuildEnvironment, modname: str, classname: str, name: str, type: str, searchmode: int = 0
    ) -> list[tuple[str, ObjectEntry]]:
        """Find objects of a name; in mode 1, in any module or class."""
        last = name.removesuffix("()").rpartition(".")[2]
        if searchmode == 1 and last not in self._last_names():
            return []
        return super().find_obj(env, modname, classname, name, type, searchmode)

    def _last_names(self) -> frozenset[str]:
        if self._n_indexed != len(self.objects):
            self._n_indexed = len(self.objects)
            self._indexed = frozenset(name.rpartition(".")[2] for name in self.objects)
        return self._indexed

    _n_indexed = -1
    _indexed: frozenset[str] = frozenset()


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the extension."""
    app.add_domain(IndexedPython, override=True)
    app.connect("builder-inited", write_pages)
    app.connect("autodoc-process-docstring", prepare, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
