import re
import subprocess
import sys

import pytest

from twin.errors import RecordingError
from twin.quantity import QUANTITIES
from twin.units import SI, quantity_of, si_factor, split_name


@pytest.mark.parametrize(
    ("unit", "kind", "factor"),
    [
        ("m/s^2", "acc", 1.0),
        ("m/s2", "acc", 1.0),
        ("m/s²", "acc", 1.0),
        ("mm/s^2", "acc", 1e-3),
        ("in/s^2", "acc", 0.0254),
        ("g", "acc", 9.80665),
        ("mg", "acc", 9.80665e-3),
        ("µg", "acc", 9.80665e-6),
        ("g0", "acc", 9.80665),
        ("Gal", "acc", 1e-2),
        ("N", "force", 1.0),
        ("kN", "force", 1e3),
        ("lbf", "force", 4.4482216152605),
        ("kgf", "force", 9.80665),
        ("kg m/s^2", "force", 1.0),
        ("mm", "disp", 1e-3),
        ("in", "disp", 0.0254),
        ("deg", "angle", 0.017453292519943295),
        ("°", "angle", 0.017453292519943295),
        ("N m", "torque", 1.0),
        ("Nm", "torque", 1.0),
        ("N*mm", "torque", 1e-3),
        ("lbf in", "torque", 0.1129848290276167),
        ("ms", "time", 1e-3),
        ("min", "time", 60.0),
    ],
)
def test_a_unit_becomes_its_factor_to_si(unit, kind, factor):
    assert si_factor(unit, kind, "x") == pytest.approx(factor, rel=1e-14)


@pytest.mark.parametrize(
    ("unit", "kind"),
    [
        ("g", "force"),  # grams are no force
        ("lbs", "force"),  # nor are pounds
        ("m/s", "acc"),
        ("V", "acc"),
        ("N", "disp"),
        ("%", "angle"),  # dimensionless, as radians are
        ("", "time"),
        ("N/m", "torque"),
        ("degC", "force"),
    ],
)
def test_a_unit_of_another_quantity_is_refused_with_examples(unit, kind):
    with pytest.raises(RecordingError, match=r"^f\.csv: column 'a': .*are written as \["):
        si_factor(unit, kind, "f.csv: column 'a'")


@pytest.mark.parametrize(
    "unit", ["furlongs per fortnight^", "((", '"', "m^", "__import__('os')", "N-", "\x00", "2 N"]
)
@pytest.mark.parametrize("kind", list(SI))
def test_what_is_no_unit_is_refused_in_one_printable_line(unit, kind):
    with pytest.raises(RecordingError, match="unknown unit") as caught:
        si_factor(unit, kind, "f.csv")
    assert str(caught.value).isprintable()


def test_a_monstrous_unit_is_shortened_in_the_message():
    with pytest.raises(RecordingError) as caught:
        si_factor("m" * 100_000, "acc", "f.csv")
    assert len(str(caught.value)) < 200


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("acc_floor1 [m/s^2]", ("acc_floor1", "m/s^2")),
        ("acc_floor1[g]", ("acc_floor1", "g")),
        (" time [ s ] ", ("time", "s")),
        ("Force", ("Force", None)),
        ("[N]", ("", "N")),
        ("a [b] c", ("a [b] c", None)),
    ],
)
def test_a_header_splits_into_name_and_unit(text, parts):
    assert split_name(text) == parts


@pytest.mark.parametrize(
    ("unit", "kind", "si", "factor"),
    [
        ("N", "force", "N", 1.0),
        ("lbf", "force", "N", 4.4482216152605),
        ("g", "acc", "m/s^2", 9.80665),
        ("mm/s", "vel", "m/s", 1e-3),
        ("rpm", "rate", "rad/s", 0.10471975511965977),
        ("deg/s^2", "angacc", "rad/s^2", 0.017453292519943295),
        ("N mm", "torque", "N m", 1e-3),
        ("um/m", "strain", "m/m", 1e-6),
        ("microstrain", "strain", "m/m", 1e-6),
        ("µε", "strain", "m/m", 1e-6),
        ("mV", "voltage", "V", 1e-3),
        ("mA", "current", "A", 1e-3),
        ("bar", "pressure", "Pa", 1e5),
        ("%", "number", "1", 0.01),
        ("-", "number", "1", 1.0),
        ("g/s", "other", "kg/s", 1e-3),
        ("degC", "other", "degC", 1.0),
    ],
)
def test_a_unit_says_the_quantity(unit, kind, si, factor):
    found = quantity_of(unit, "x")
    assert found[:2] == (kind, si)
    assert found[2] == pytest.approx(factor, rel=1e-12)
    assert quantity_of(si, "x") == (kind, si, 1.0), "written in SI, it is read as the same"


def test_every_kind_is_said_by_its_own_unit_and_examples():
    for kind, quantity in QUANTITIES.items():
        for unit in (quantity.unit, *re.findall(r"\[(.*?)\]", quantity.examples)):
            assert quantity_of(unit, "x")[:2] == (kind, quantity.unit)


def test_units_in_si_do_not_load_pint():
    code = (
        "import sys; from twin.units import si_factor; import twin.formats.csv;"
        "si_factor('N', 'force', ''); sys.exit('pint' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
