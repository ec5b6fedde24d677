"""Makes the type stub of the native module, or with ``--check`` says whether it is up to date.

``maturin`` must be installed. It reads what the library says about itself; imports of the types that it cannot know are added here.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).parent
STUB = HERE / "python" / "microslip" / "_native.pyi"


def made() -> str:
    """The stub, from a build of the library with its descriptions."""
    with tempfile.TemporaryDirectory() as folder:
        command = ["maturin", "generate-stubs", "-m", HERE / "Cargo.toml", "--profile", "release", "-F", "stubs", "-o", folder]
        subprocess.run([*command, "--", "-C", "strip=none"], check=True)
        (path,) = Path(folder).rglob("_native.pyi")
        text = path.read_text(encoding="utf-8")
    # Types that are given as texts are texts, and modules with initialisers count as open.
    text = re.sub(r'((?:->|:) )"([^"\n]+)"', r"\1\2", text)
    text = text.replace("from _typeshed import Incomplete\n", "").replace("import Incomplete, ", "import ").replace("\ndef __getattr__(name: str) -> Incomplete: ...\n", "")
    # Dictionaries hold what is named.
    text = re.sub(r"(-> )dict(:)", r"\1dict[str, Any]\2", text)
    modules = [m for m in ("collections.abc", "numpy", "numpy.typing") if re.search(rf"\b{re.escape(m)}\.", text)]
    imports = "".join(f"import {module}\n" for module in modules)
    assert "Incomplete" not in text, "a type is not known: annotate it in the signature"
    names = sorted(re.findall(r"^(?:def|class) (\w+)", text, re.MULTILINE))
    exported = "".join(f"    {name!r},\n" for name in names).replace("'", '"')
    text += f"\n__all__ = [\n{exported}]\n"
    return text.replace("from typing import", f"{imports}from typing import", 1)


def main() -> int:
    text = made()
    if "--check" not in sys.argv[1:]:
        STUB.write_text(text, encoding="utf-8")
    elif STUB.read_text(encoding="utf-8") != text:
        sys.stderr.write(f"{STUB} is out of date: python {Path(__file__).name} makes it anew\n")
        return 1
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
