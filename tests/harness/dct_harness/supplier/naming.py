"""How alike two variables are, by the words of their names and descriptions and by their units."""

from __future__ import annotations

import re
from typing import Any

from ..units import KNOWN, Unit, declared

# Words that mean the same in the names of suppliers; each row is one idea.
IDEAS = (
    "engine eng motor mot ice vkm crank kurbelwelle",
    "speed spd n omega w drehzahl rpm geschw v velocity",
    "torque trq tq tqe moment m trm mind drehmoment",
    "clutch cl clu cltch kuppl kupplung k kup",
    "position pos stroke travel weg ausrueck ausrueckweg strk s",
    "pressure prs press druck p",
    "wheel whl rad wheels raedern rader",
    "vehicle veh fzg fahrzeug car fahrzeugs",
    "acceleration accel acc a beschleunigung laengsbeschleunigung",
    "brake brk brems bremse bremsmoment",
    "road rd strasse street",
    "grade grd slope neigung steigung incline gradient",
    "shaft sh welle eingangswelle teilgetriebe tg insh inputshaft",
    "gear gang gng ratio rat uebersetzung i",
    "driveshaft drvsh drvshaft gelenkwelle halfshaft seitenwelle",
    "state sts status zustand mode",
    "slip ndiff diff differenz differenzdrehzahl schlupf",
    "damper dmp daempfer torsionsdaempfer hub clhub nabe",
    "inertia iner j massentraegheit traegheit",
    "stiffness stf steifigkeit c",
    "damping dmpg daempfung d",
    "mass masse",
    "radius r rollradius lever hebel",
    "start init initial anfang n0",
    "output out abtrieb",
    "temperature temp tmp t temperatur",
    "friction fric mue mu reibwert reibung",
    "frontal area stirnflaeche",
    "drag cw luftwiderstandsbeiwert",
    "rolling roll rollwiderstand rollwiderstandsbeiwert fr rollres",
    "load last",
    "finaldrive achse achsuebersetzung",
)
# Other words for what a name of ours means.
ALIASES = {f"clutch{k}.speed": f"shaft{k}.speed" for k in (1, 2)}
IDEA_OF = {word: k for k, row in enumerate(IDEAS) for word in row.split()}
FINAL_DRIVE = IDEA_OF["finaldrive"]
SUFFIXES = {
    "rpm": "rpm", "nm": "N.m", "mm": "mm", "kmph": "km/h", "kph": "km/h", "deg": "deg",
    "bar": "bar", "degc": "degC", "kgm2": "kg.m2", "kg": "kg", "pct": "%", "nmprad": "N.m/rad",
    "nmsprad": "N.m.s/rad", "mps": "m/s", "rads": "rad/s", "knm": "kN.m",
}  # fmt: skip
# The numbers of our names, as suppliers count: odd and even shafts, single gears.
ODD_EVEN = {"odd": "1", "even": "2", "ungerade": "1", "gerade": "2"}
ALIKE = 0.5  # below this two variables are no pair


def words(name: str) -> tuple[list[str], set[str]]:
    """Return the words of a name in lower case, and the numbers in it."""
    text = re.sub(r"([a-z])([A-Z])", r"\1 \2", name.replace("ß", "ss"))
    text = re.sub(r"([A-Z]+)([A-Z][a-z])", r"\1 \2", text)
    parts = [p.lower() for p in re.findall(r"[^\W\d_]+|\d+", text)]
    numbers = {p for p in parts if p.isdigit()} | {ODD_EVEN[p] for p in parts if p in ODD_EVEN}
    return [p for p in parts if not p.isdigit() and p not in ODD_EVEN], numbers


def ideas(name: str) -> set[int | str]:
    """Return what a name is about; neighbouring words may be one (drive shaft, ClHub)."""
    parts = [w for w in words(name)[0] if w not in SUFFIXES or w in IDEA_OF]
    found: set[int | str] = set()
    skip = False
    for k, word in enumerate(parts):
        pair = word + parts[k + 1] if k + 1 < len(parts) else ""
        if skip:
            skip = False
        elif pair in IDEA_OF:
            found.add(IDEA_OF[pair])
            skip = True
        else:
            found.add(IDEA_OF.get(word, word))
    return found


def unit_of_name(name: str) -> str:
    """Return the unit that a name ends with, `EngSpd_rpm`; empty if none."""
    last = re.split(r"[_.]", name)[-1].lower()
    return SUFFIXES.get(last, "") if re.search(r"[_.]", name) else ""


def unit_of(description: Any, variable: Any) -> Unit | None:
    """Return the unit that an FMU states, else the one at the end of the name; None if none."""
    _, unit = declared(description, variable)
    return unit or KNOWN.get(unit_of_name(variable.name))


def likeness(ours: Any, our_unit: Unit, theirs: Any, their_unit: Unit | None) -> float:
    """Return 0 to 1: shared ideas of the names and, at half weight, of the description.

    Units of other quantities and other numbers (clutch 1, clutch 2) never fit, nor does the ratio
    of a gear that of a final drive.
    """
    if ours.type == "Real" and their_unit and their_unit.exponents != our_unit.exponents:
        return 0.0
    if (ours.type == "Real") != (theirs.type == "Real") or theirs.type == "String":
        return 0.0
    if words(ours.name)[1] not in (words(theirs.name)[1], words(theirs.description or "")[1]):
        return 0.0
    about = ideas(theirs.name) | ideas(theirs.description or "")
    if (FINAL_DRIVE in ideas(ours.name)) != (FINAL_DRIVE in about):
        return 0.0
    names = (ours.name, ALIASES.get(ours.name, ours.name))
    sure = 1.0 if their_unit or ours.type != "Real" else 0.9
    return sure * max(_shared(ideas(name), theirs) for name in names)


def _shared(wanted: set[int | str], theirs: Any) -> float:
    """Return how many of the wanted ideas a variable of theirs has, 0 to 1."""
    named, told = ideas(theirs.name), ideas(theirs.description or "")
    shared = len(wanted & named) + 0.5 * len((wanted & told) - named)
    excess = len(named - wanted) / max(len(named), 1)
    return shared / max(len(wanted), 1) * (1 - 0.3 * excess)
