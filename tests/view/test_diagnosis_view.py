"""The report and the Rerun recording of a diagnosis, from one made by hand."""

from dataclasses import replace
from io import StringIO

import pytest
from diagnosis_example import SLIP, diagnosis
from rich.console import Console

from twin.view.diagnosis_rrd import located_forces, write_diagnosis_rrd
from twin.view.diagnosis_tables import print_diagnosis
from twin.view.page.diagnosis import report, write_report


@pytest.fixture(scope="module")
def html():
    return report(diagnosis())


def test_the_report_names_the_finding_its_place_and_the_next_test(html):
    assert "cubic stiffness" in html
    assert "storey 1" in html
    assert "twin test shaker --model two_storey_lumped" in html


def test_a_hostile_file_name_stays_text(html):
    assert "<script>alert" not in html
    assert "&lt;script&gt;" in html


def test_a_report_is_written_whole(tmp_path):
    path = write_report(diagnosis(SLIP), tmp_path / "found.html")
    assert path.read_text(encoding="utf-8").rstrip().endswith("</html>")


def test_the_terminal_shows_findings_errors_and_advice():
    out = StringIO()
    print_diagnosis(Console(file=out, width=160), diagnosis())
    assert "cubic stiffness" in out.getvalue()
    assert "noise floor" in out.getvalue()
    assert "next experiment" in out.getvalue()


def test_the_rerun_recording_holds_signals_verdict_and_the_lit_storey(tmp_path):
    from rerun.chunk import RrdReader

    path = write_diagnosis_rrd(diagnosis(), tmp_path / "found.rrd")
    names = {str(chunk.entity_path) for chunk in RrdReader(path).stream().to_chunks()}
    assert "/recording1/signals/acc_floor1/3_extended" in names
    assert "/recording4/residual/acc_floor2/2_calibrated" in names
    assert "/frame/located/storey1" in names
    assert "/frame/extended/floor1" in names
    assert "/frame/calibrated/floor1" in names
    assert "/missing_force/storey1/1_latent" in names
    assert "/verdict" in names


def test_no_force_is_drawn_in_rerun_where_nothing_was_found():
    found = diagnosis()
    elsewhere = replace(found.force[0], place="storey2")
    both = replace(found, force=(*found.force, elsewhere))
    assert [p.place for p in located_forces(both)] == ["storey1"]
    assert located_forces(replace(both, findings=())) == []
