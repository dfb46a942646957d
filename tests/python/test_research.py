"""Procedures, judgements, contact methods, reports and renderings in Python."""

import importlib.util
import os
import sys
import types
from pathlib import Path

import numpy as np
import pytest
import trephine as tr
from trephine.meshes import to_trimesh, to_vtk
from trephine.methods import compare, run_method
from trephine.procedure import Command, Procedure, perform
from trephine.program import audit, call, find_program, report, ticks

HAS_PROGRAM = "TREPHINE_COMMAND" in os.environ


def sphere(**hand):
    return tr.Operation.open(tr.Scan.phantom("sphere", spacing=(1, 1, 1), radius=30), iso=300, hand=tr.Hand(**hand))


def drilled(**hand):
    return sphere(instrument="burr", **{"diameter": 6, "removal_rate": 200, **hand})


def path_down(ticks, start=40.0, end=25.0):
    path = np.zeros((ticks, 3))
    path[:, 2] = np.linspace(start, end, ticks)
    return path


class Observer(Procedure):
    """Records its observations. Returns `commands[n]` after observation n, and completes after observation `end`."""

    interval = 30

    def __init__(self, commands=None, end=None):
        super().__init__()
        self.commands, self.end, self.seen = commands or {}, end, []

    def start(self, operation):
        return [Command("note", text="begin")]

    def observe(self, observation):
        self.seen.append((len(observation.touches.contact), [event.name for event in observation.events]))
        if len(self.seen) == self.end:
            self.complete("enough")
        return self.commands.get(len(self.seen), [])


def test_a_procedure_gives_the_bits_of_the_same_path_and_commands():
    path = path_down(1000)
    direct = drilled()
    direct.command("note", text="begin")
    direct.run(path[:300], buttons=1)
    direct.command("burr", diameter=8)
    direct.run(path[300:], buttons=1)
    operation = drilled()
    observer = Observer({10: [Command("burr", diameter=8)]})
    outcome = perform(operation, observer, path, buttons=1)
    assert outcome == (None, 1000, [])
    assert operation.hash == direct.hash
    assert [count for count, _ in observer.seen] == [30] * 33 + [10]
    assert sum((names for _, names in observer.seen), []) == [e.name for e in direct.events]


def test_a_procedure_ends_and_lists_refused_commands():
    operation = drilled()
    observer = Observer({2: [Command("hold-body", body=7), Command("note", text="after")]}, end=5)
    outcome = perform(operation, observer, path_down(1000), buttons=1)
    assert outcome.reason == "enough" and outcome.ticks == 150 == operation.tick
    ((command, reason),) = outcome.refused
    assert command.name == "hold-body" and "body" in reason
    with pytest.raises(NotImplementedError):
        perform(operation, Procedure(), path_down(30))
    for arguments in [(np.zeros(3),), (np.zeros((4, 2)),), (np.zeros((4, 3)), np.zeros((3, 4))),
                      (np.zeros((4, 3)), None, [1, 1])]:
        with pytest.raises(ValueError):
            perform(operation, Observer(), *arguments)


def test_a_procedure_of_two_hands_sees_both():
    operation = tr.Operation.open(tr.Scan.phantom("sphere", spacing=(1, 1, 1), radius=30), iso=300,
                                  hands=[tr.Hand("burr", diameter=6, removal_rate=200), tr.Hand()])
    path = np.stack([path_down(90), path_down(90) + (60, 0, 0)], axis=1)
    observer = Observer()
    assert perform(operation, observer, path, buttons=np.tile([1, 0], (90, 1))).ticks == 90
    assert len(observer.seen) == 3


def test_judgements_are_scored_like_those_of_the_modules():
    operation = drilled()
    own = operation.score()
    judged = operation.score([tr.MeasuredValue("a", 3.0, unit="mm", full_at=2, zero_at=4, weight=2),
                              tr.MeasuredValue("b", 9.0, full_at=0, zero_at=4, weight=4),
                              tr.MeasuredValue("c", None, full_at=0, zero_at=1, reason="It was not measured."),
                              tr.MeasuredValue("d", 7.0)])
    a, b, c, d = judged["findings"][-4:]
    assert (a["verdict"], a["points"], a["unit"]) == ("fair", 1.0, "mm")
    assert (b["verdict"], b["points"]) == ("bad", 0.0) and judged["critical"] == own["critical"] + ["b"]
    assert c["verdict"] == "not judged" and c["reason"] == "It was not measured." and c["value"] is None
    assert d["verdict"] == "reported"
    assert judged["points"] == own["points"] + 1 and judged["possible"] == own["possible"] + 6
    assert judged["not_judged"] == own["not_judged"] + 1
    for wrong, part in [([tr.MeasuredValue("a", 1.0), tr.MeasuredValue("a", 2.0)], "same name"),
                        ([tr.MeasuredValue("undos", 1.0)], "same name"), ([tr.MeasuredValue("", 1.0)], "not valid"),
                        ([tr.MeasuredValue("a", np.nan)], "not valid"), ([3], "wrong type")]:
        with pytest.raises(tr.Error, match=part):
            operation.score(wrong)
    with pytest.raises(tr.Error, match="one limit"):
        tr.MeasuredValue("a", 1.0, full_at=2)


def test_renderings_show_cuts_and_refuse_unknown_names():
    operation = drilled()
    before = operation.render("top", columns=120, rows=90)
    assert before.shape == (90, 120, 3) and before.dtype == np.uint8
    assert np.array_equal(before, operation.render("top", columns=120, rows=90))
    operation.run(path_down(2000, end=27), buttons=1)
    after = operation.render("top", columns=120, rows=90)
    changed = (before != after).any(axis=2)
    assert changed.any()
    # The changed pixels are few, and in the middle of the view from above.
    rows, columns = np.nonzero(changed)
    assert abs(rows.mean() - 45) < 4 and abs(columns.mean() - 60) < 4 and changed.mean() < 0.1
    for arguments, part in [(("inside",), "unknown side"), (("top", "gold"), "unknown transfer"),
                            (("top", "bone", 0, 4), "size"), (("top", "bone", 9000, 4), "size")]:
        with pytest.raises(tr.Error, match=part):
            operation.render(*arguments)


def stop_at_matter(matter, radius):
    """A contact method: the proxy follows the hand in free space. In matter it stays at its last free position."""
    free = []

    def step(hand):
        if not free or not matter.query(hand[None])["solid"][0]:
            free[:] = [hand]
        return free[0]

    return step


def test_a_method_in_lockstep_changes_nothing():
    operation = sphere()
    before = operation.hash
    path = path_down(500, end=26)
    result = run_method(operation, stop_at_matter, path, stiffness=0.5)
    assert operation.hash == before and operation.tick == 0
    free = path[:, 2] > 30.2
    assert np.array_equal(result.proxy[free], path[free]) and not result.force[free].any()
    assert result.proxy[-1, 2] == pytest.approx(30, abs=0.1)
    assert result.force[-1] == pytest.approx([0, 0, 0.5 * (result.proxy[-1, 2] - 26)], abs=1e-12)
    assert (result.microseconds > 0).all()
    with pytest.raises(ValueError, match="no point in tick 0"):
        run_method(operation, lambda matter, radius: lambda hand: [0, 1], path)
    with pytest.raises(ValueError, match="shape"):
        run_method(operation, stop_at_matter, np.zeros((3, 2)))


@pytest.mark.skipif(not HAS_PROGRAM, reason="the programs were not built")
def test_a_method_gets_a_row_beside_ours(tmp_path):
    rows = compare(stop_at_matter, tmp_path / "out", scenes="sphere-psf-1.5-slide-100", methods=["subvoxel"])
    methods = {row["method"]: row for row in rows if "held" not in row["motion"]}
    mine, ours = methods["stop_at_matter"], methods["subvoxel"]
    assert ours["total_rms_voxels"] < 0.1 < mine["total_rms_voxels"]  # stop_at_matter does not slide
    assert mine["step_us"]["p50"] > 0
    assert "stop_at_matter" in (tmp_path / "out" / "index.html").read_text()


@pytest.mark.skipif(not HAS_PROGRAM, reason="the programs were not built")
@pytest.mark.skipif("TREPHINE_WHOLE" not in os.environ, reason="longer than 5 s")
def test_a_report_of_a_session(tmp_path):
    operation = tr.Operation.open("spine", hand=tr.Hand("burr", diameter=4), record=tmp_path / "a.session")
    operation.run(np.tile((0.0, 60.0, 0.0), (300, 1)))
    operation.end()
    report(tmp_path / "a.session", tmp_path / "a.html")
    assert "<h1>" in (tmp_path / "a.html").read_text()
    assert call("timeline", tmp_path / "a.session")["rows"] == []
    with pytest.raises(tr.Error) as caught:
        report(tmp_path / "none.session", tmp_path / "b.html")
    assert caught.value.what and not (tmp_path / "b.html").exists()
    assert find_program() == str(Path(os.environ["TREPHINE_COMMAND"]).resolve())
    with pytest.raises(FileNotFoundError, match="TREPHINE_PROGRAMS"):
        find_program("no-such-program")


@pytest.mark.skipif(not HAS_PROGRAM, reason="the programs were not built")
def test_sessions_are_audited_and_their_ticks_are_arrays(tmp_path):
    operation = tr.Operation.open("spine", hand=tr.Hand("burr", diameter=4, removal_rate=100), record=tmp_path / "a.session")
    path = np.tile((0.0, 60.0, 0.0), (400, 1))
    path[:, 1] = np.linspace(75, 52, 400)
    touches = operation.run(path, buttons=1)
    operation.end()
    assert audit(tmp_path / "a.session")["is_certified"] is True
    columns = ticks(tmp_path / "a.session")
    assert len(columns["t"]) == 400
    assert np.array_equal(np.stack([columns[f"force_{axis}"] for axis in "xyz"], axis=1), touches.force)
    assert set(columns["shape"]) <= {"", "bone"} and (columns["contact"] == touches.contact).all()


def test_surfaces_become_meshes_of_other_libraries(monkeypatch):
    surface = sphere().surface()
    if importlib.util.find_spec("vtkmodules"):
        mesh = to_vtk(surface)
        assert mesh.GetNumberOfPoints() == len(surface.vertices)
        assert mesh.GetNumberOfCells() == len(surface.triangles)
        assert mesh.GetPoint(7) == tuple(surface.vertices[7])
        ids = mesh.GetCell(11).GetPointIds()
        assert [ids.GetId(i) for i in range(3)] == surface.triangles[11].tolist()
    # A stand-in for trimesh, which is not a package of Debian.
    stand_in = types.ModuleType("trimesh")
    stand_in.Trimesh = lambda **arguments: arguments
    monkeypatch.setitem(sys.modules, "trimesh", stand_in)
    mesh = to_trimesh(surface)
    assert np.array_equal(mesh["vertices"], surface.vertices) and np.array_equal(mesh["faces"], surface.triangles)
    assert mesh["process"] is False


def test_mistakes_of_procedures_and_methods_are_reported(tmp_path):
    for commands, problem in (({1: "undo"}, TypeError), ({1: Command("undo")}, TypeError), ({1: None}, TypeError),
                              ({1: [Command("undooo")]}, tr.Error), ({1: [Command("note", txt="x")]}, tr.Error)):
        with pytest.raises(problem):
            perform(drilled(), Observer(commands), path_down(100))
    with pytest.raises(tr.Error, match="buttons"):
        perform(drilled(), Observer(), path_down(100), buttons=0.7)
    refused = perform(drilled(), Observer({1: [Command("hold-body", body=3)]}), path_down(100)).refused
    assert [command.name for command, _ in refused] == ["hold-body"]
    for result in (lambda hand: hand * 1j, lambda hand: np.nan * hand):
        with pytest.raises(ValueError, match="no point in tick 0"):
            run_method(sphere(), lambda matter, radius: result, path_down(3))
    with pytest.raises(ValueError, match="stiffness"):
        run_method(sphere(), stop_at_matter, path_down(3), stiffness=float("nan"))
    with pytest.raises(ValueError, match="letters"):
        compare(stop_at_matter, tmp_path / "out", name="a/b")
    with pytest.raises(TypeError, match="list of names"):
        compare(stop_at_matter, tmp_path / "out", methods="mesh")


@pytest.mark.skipif(not HAS_PROGRAM, reason="the programs were not built")
def test_sessions_of_an_array_are_audited_with_their_scan(tmp_path):
    voxels = np.full((40, 40, 40), -1000, np.int16)
    voxels[:, :, :20] = 1200
    scan = tr.Scan(voxels, spacing=(0.5, 0.6, 0.7), hounsfield=True)
    operation = tr.Operation.open(scan, iso=300, hand=tr.Hand("burr", diameter=3), record=tmp_path / "a.session")
    path = np.tile((0.0, 12.0, 14.0), (200, 1))
    path[:, 0] = np.linspace(14, 8, 200)
    touches = operation.run(path, buttons=1)
    operation.end()
    assert touches.contact.any()
    assert audit(tmp_path / "a.session", scan=scan)["is_certified"] is True
    columns = ticks(tmp_path / "a.session", scan=scan)
    assert np.array_equal(columns["force_x"], touches.force[:, 0]) and set(columns["hand"]) == {0}
    with pytest.raises(tr.Error, match="remedy"):
        audit(tmp_path / "a.session")
    with pytest.raises(tr.Error, match="unknown scene"):
        compare(stop_at_matter, tmp_path / "out", scenes="zz")
