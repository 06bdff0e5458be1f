"""Build the two suppliers' plants of this folder as FMUs.

Run `python build.py OUT [antrieb] [powertrain]`. The C plant needs a C compiler; the Python plant
needs the package pythonfmu (`pip install pythonfmu==0.7.0`), and at run time this same Python.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import fmpy

HERE = Path(__file__).resolve().parent
HEADERS = Path(fmpy.__file__).parent / "c-code"


def antrieb(out: Path) -> Path:
    """Compile the C plant and write Antrieb.fmu."""
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / f"antrieb{fmpy.sharedLibraryExtension}"
        command = ["cc", "-std=c11", "-O2", "-Wall", "-Wextra", "-shared", "-fPIC", f"-I{HEADERS}"]
        subprocess.run([*command, HERE / "antrieb.c", "-o", library, "-lm"], check=True)
        with zipfile.ZipFile(out / "Antrieb.fmu", "w", zipfile.ZIP_DEFLATED) as archive:
            archive.write(HERE / "antrieb.xml", "modelDescription.xml")
            archive.write(library, f"binaries/{fmpy.platform}/{library.name}")
    return out / "Antrieb.fmu"


def powertrain(out: Path) -> Path:
    """Pack the Python plant with PythonFMU into Powertrain.fmu."""
    try:
        from pythonfmu.builder import FmuBuilder
    except ImportError:
        sys.exit("the Python plant needs PythonFMU: python -m pip install pythonfmu==0.7.0")
    return Path(FmuBuilder.build_FMU(HERE / "powertrain.py", out / "Powertrain.fmu"))


PLANTS = {"antrieb": antrieb, "powertrain": powertrain}


def main() -> None:
    """Build what the command line names, everything when it names nothing."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("plants", nargs="*", metavar="PLANT", help=", ".join(PLANTS))
    args = parser.parse_args()
    unknown = set(args.plants) - set(PLANTS)
    if unknown:
        parser.error(f"no plant {', '.join(sorted(unknown))}; there are {', '.join(PLANTS)}")
    args.out.mkdir(parents=True, exist_ok=True)
    for name in args.plants or PLANTS:
        print(PLANTS[name](args.out))


if __name__ == "__main__":
    main()
