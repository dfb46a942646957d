"""The Python module: equal bits in every run, arrays that outlive their owners, errors with messages."""

import gc
import os
import pickle
import signal
import subprocess
import threading

import numpy as np
import pytest
import trephine as tr


def sphere(spacing=(1.5, 1.5, 1.5), radius=30.0):
    return tr.Scan.phantom("sphere", spacing=spacing, radius=radius)


def path_down(ticks, start=40.0, depth=0.05):
    positions = np.zeros((ticks, 3))
    positions[:, 2] = start - depth * np.arange(ticks)
    return positions


def test_scan_is_a_view_of_shape_zyx():
    scan = tr.Scan.phantom("sphere", spacing=(1.0, 2.0, 4.0))
    assert scan.array.shape == scan.shape
    assert scan.array.dtype == np.int16
    assert scan.shape[0] < scan.shape[1] < scan.shape[2]
    assert scan.spacing == (1.0, 2.0, 4.0)
    with pytest.raises(ValueError):
        scan.array[0, 0, 0] = 1
    # World positions and voxel indices.
    points = scan.world(np.array([[0, 0, 0], [1, 0, 0], [0, 0, 2]]))
    assert np.allclose(points[0], scan.origin)
    assert np.allclose(points[1] - points[0], (1, 0, 0)) and np.allclose(points[2] - points[0], (0, 0, 8))
    assert np.allclose(scan.voxel(points)[2], (0, 0, 2))


def test_views_outlive_their_owners():
    array = tr.Scan.phantom("sphere", spacing=(3, 3, 3)).array
    gc.collect()
    assert array.max() == 1600
    operation = tr.Operation.open(sphere((3, 3, 3)))
    voxels = operation.array
    del operation
    gc.collect()
    assert voxels.min() == -1000


def test_scan_of_an_array():
    voxels = np.full((40, 50, 60), -1000, np.int16)
    voxels[:20] = 1000
    scan = tr.Scan(voxels, spacing=(1, 1, 1), origin=(-30, -25, -20))
    assert np.array_equal(scan.array, voxels)
    voxels[:] = 0  # the scan has a copy
    assert scan.array.max() == 1000
    touches = tr.Operation.open(scan, iso=300).run(path_down(600, 20))
    assert touches.contact[-1] and abs(touches.proxy[-1, 2] - -0.5) < 0.6
    with pytest.raises(tr.Error) as raised:
        tr.Scan(voxels.astype(np.float64), spacing=(1, 1, 1))
    assert "int16" in raised.value.remedy


def test_touch_of_a_sphere():
    operation = tr.Operation.open(sphere(), iso=300)
    touches = operation.run(path_down(1000))
    assert touches.proxy.shape == (1000, 3) and touches.contact.shape == (1000,)
    assert not touches.contact[0] and touches.contact[-1]
    assert abs(touches.proxy[-1, 2] - 30) < 0.1
    assert touches.force[-1, 2] > 1 and np.allclose(touches.normal[-1], (0, 0, 1), atol=0.01)
    assert operation.tick == 1000


def test_runs_are_the_same_bits():
    def play(parts):
        operation = tr.Operation.open(sphere(), hand=tr.Hand("burr", diameter=6, removal_rate=200), iso=300)
        forces = [operation.run(part, buttons=1).force for part in np.array_split(path_down(1200), parts)]
        return operation.hash, operation.removed_mm3, np.concatenate(forces)

    whole, parts = play(1), play(7)
    assert whole[0] == parts[0] and whole[1] == parts[1] > 50
    assert np.array_equal(whole[2], parts[2])


def test_commands_events_and_undo():
    operation = tr.Operation.open(sphere(), hand=tr.Hand("burr", diameter=6, removal_rate=200), iso=300)
    operation.run(path_down(1200), buttons=1)
    operation.run(path_down(10), buttons=0)
    removed = operation.measures["removed"]
    assert removed > 50
    low = [int(i) for i in tr_voxel(operation, (-4, -4, 24))]
    high = [int(i) for i in tr_voxel(operation, (4, 4, 30))]
    box = operation.read(low, high)
    assert box.dtype == np.int16 and box.shape == tuple(h - l + 1 for l, h in zip(low, high))[::-1]
    assert (box < 0).any()
    operation.undo()
    assert operation.removed_mm3 == 0
    operation.redo()
    assert operation.measures["removed"] == removed
    operation.command("note", text='a "quoted" remark')
    operation.command("burr", diameter=7)
    for event in operation.events:
        assert event.tick <= operation.tick and isinstance(event.fields, dict)


def tr_voxel(operation, point):
    scan = sphere()
    assert operation.array.shape == scan.shape
    return np.round(scan.voxel(np.array([point], float))[0])


def test_sessions_are_recorded_and_verified(tmp_path):
    path = tmp_path / "a.session"
    operation = tr.Operation.open("head", hand=tr.Hand("burr", diameter=5, removal_rate=100), record=path)
    positions = np.zeros((800, 3))
    positions[:, 1] = -20
    positions[:, 2] = 80 - 0.03 * np.arange(800)
    operation.run(positions, buttons=1)
    final = operation.hash
    operation.end()
    session = tr.Operation.reopen(path)
    assert session.tick_count == 800
    session.verify()
    session.go_to(800)
    assert session.hash == final
    session.go_to(100)
    assert session.tick == 100
    with pytest.raises(tr.Error):
        session.run(positions)


def test_scores_judge_the_current_state(tmp_path):
    session = str(tmp_path / "a.session")
    hand = tr.Hand("burr", diameter=7, removal_rate=100)
    operation = tr.Operation.open("head", plan=True, hand=hand, record=session)
    uncut = operation.score()
    assert uncut["points"] == uncut["possible"] == sum(f["weight"] for f in uncut["findings"])
    assert all(f["verdict"] in ("good", "reported") for f in uncut["findings"])
    positions = path_down(4000, start=70, depth=0.008)
    positions[:, 1] = -20
    operation.run(positions, buttons=1)
    injured = operation.score()
    by_name = {f["name"]: f for f in injured["findings"]}
    assert len(by_name) == len(injured["findings"])
    torn = by_name["venous_sinus: torn"]
    assert (torn["value"], torn["verdict"], torn["points"]) == (1, "bad", 0)
    assert 0 < torn["tick"] < 4000 and abs(torn["position"][1] + 20) < 5
    assert injured["points"] < uncut["points"]
    operation.end()
    # A recorded state has the same score.
    recorded = tr.Operation.reopen(session)
    recorded.go_to(recorded.tick_count)
    assert recorded.score() == injured
    recorded.go_to(0)
    assert recorded.score() == uncut


def test_a_phantom_in_memory_has_its_plan():
    path = path_down(300, start=62, depth=0.02)
    operations = [tr.Operation.open(source, plan=True, hand=tr.Hand("burr")) for source in ("spine", tr.Scan.phantom("spine"))]
    touches = [operation.run(path) for operation in operations]
    assert np.array_equal(touches[0].force, touches[1].force)
    assert operations[0].score() == operations[1].score() and len(operations[0].score()["findings"]) > 5
    for scan in (sphere(), tr.Scan.phantom("spine", seed=2)):
        with pytest.raises(tr.Error, match="no plan"):
            tr.Operation.open(scan, plan=True)


def test_surface_slice_and_xray():
    operation = tr.Operation.open(sphere(), iso=300)
    surface = operation.surface()
    assert surface.vertices.shape[1] == 3 and surface.triangles.max() < len(surface.vertices)
    assert abs(np.linalg.norm(surface.vertices, axis=1).mean() - 30) < 0.1
    image = operation.slice((0, 0, 0), columns=100, rows=80, pixel=1.0)
    assert image.shape == (80, 100) and image[40, 50] == 1600 and image[0, 0] == -1000
    xray = operation.xray((0, 0, 0), columns=64, rows=64, pixel=2)
    assert xray.shape == (64, 64) and xray.dtype == np.uint8 and xray.std() > 1


def test_queries_change_nothing():
    operation = tr.Operation.open(sphere(), hand=tr.Hand("burr", diameter=8, kinematic=True))
    points = np.array([[0, 0, 0], [0, 0, 28], [0, 0, 32], [0, 0, 1e4], [np.nan, 0, 0]])
    state = operation.hash
    first = operation.query(points)
    assert operation.hash == state
    assert first["solid"].tolist() == [True, True, False, False, False]
    assert first["item"].tolist() == [0, 0, 0, -1, -1]
    assert first["gradient"].shape == (5, 3)
    assert np.all(first["gradient"][1][2] < 0), "the value falls outward"
    operation.run(path_down(300, start=40, depth=0.05), buttons=1)
    now = operation.query(points)
    assert now["removed"].tolist() == [False, True, False, False, False]
    assert not now["solid"][1] and now["cut_distance"][1] < 0
    assert np.array_equal(first["value"], now["value"]), "values are those of the uncut scan"
    operation.undo()
    assert operation.query(points)["solid"][1]
    for wrong in (np.zeros(3), np.zeros((2, 2)), np.zeros((2, 2, 3)), "points"):
        with pytest.raises(tr.Error):
            operation.query(wrong)


def test_the_force_of_a_recorded_tick_is_explained(tmp_path):
    scan = sphere()
    file = tmp_path / "a.session"
    operation = tr.Operation.open(scan, hand=tr.Hand(effects=["constant force=0,0.5,0 most=3"]), record=file)
    touches = operation.run(path_down(400))
    operation.end()
    session = tr.Operation.reopen(file, scan)
    parts = session.explain_force(350)
    assert {"spring", "constant"} <= {part["name"].split()[0] for part in parts}
    total = np.sum([part["force"] for part in parts], axis=0)
    assert np.allclose(total, touches.force[350], atol=1e-6)
    assert session.tick == 351
    with pytest.raises(tr.Error):
        session.explain_force(10**9)
    with pytest.raises(tr.Error):
        operation.explain_force(3)


def test_two_hands():
    operation = tr.Operation.open(sphere(), hands=[tr.Hand(), tr.Hand()], iso=300)
    positions = np.stack([path_down(400), path_down(400, 60)], axis=1)
    touches = operation.run(positions)
    assert touches.force.shape == (400, 2, 3)
    assert not touches.contact[:, 1].any()
    with pytest.raises(tr.Error, match="number of hands"):
        operation.run(path_down(10))


def test_errors_state_problem_and_remedy():
    with pytest.raises(tr.Error) as raised:
        tr.Operation.open("no such scan")
    assert raised.value.what and raised.value.remedy
    assert isinstance(raised.value, ValueError)
    operation = tr.Operation.open(sphere((3, 3, 3)), iso=300)
    for bad in (np.zeros((10, 2)), np.zeros(3), np.array([["a", "b", "c"]]), "text"):
        with pytest.raises(tr.Error):
            operation.run(bad)
    with pytest.raises(tr.Error, match="buttons"):
        operation.run(np.zeros((10, 3)), buttons=np.zeros(9, int))
    with pytest.raises(tr.Error):
        operation.command("burr", no_such_parameter=1)
    with pytest.raises(tr.Error, match="unknown option"):
        tr.Operation.open(sphere((3, 3, 3)), isso=300)
    # A pose that is not a number gives no force and latches a fault.
    touches = operation.run(np.full((2, 3), np.nan))
    assert (touches.force == 0).all() and (touches.faults != 0).all()
    operation.reset()
    assert (operation.run(np.zeros((2, 3)) + 50).faults == 0).all()


def test_snapshots_give_equal_bits():
    operation = tr.Operation.open(sphere((2, 2, 2)), hand=tr.Hand("burr", diameter=5, removal_rate=200))
    path = path_down(400)
    operation.run(path[:250], buttons=1)
    snapshot = operation.snapshot()
    assert snapshot.tick == operation.tick == 250
    first = operation.run(path[250:], buttons=1)
    state = operation.hash
    operation.undo()
    operation.restore(snapshot)
    again = operation.run(path[250:], buttons=1)
    assert np.array_equal(first.force, again.force) and operation.hash == state
    assert np.abs(first.force).max() > 0.1 and operation.removed_mm3 > 1
    with pytest.raises(tr.Error, match="another operation"):
        tr.Operation.open(sphere((2, 2, 2))).restore(snapshot)
    with pytest.raises(TypeError):
        pickle.dumps(snapshot)


def test_invalid_arguments_are_errors_with_their_name(tmp_path):
    scan = sphere((5, 5, 5))
    hand = tr.Hand("burr", diameter=4)
    for name, options in (
        ("hands", {"hand": hand, "hands": [hand]}),
        ("hand", {"hand": "burr"}),
        ("hands", {"hands": hand}),
        ("iso", {"iso": "high"}),
        ("window", {"window": 300}),
        ("rate", {"rate": None}),
        ("record", {"record": 3}),
    ):
        with pytest.raises(tr.Error, match=name):
            tr.Operation.open(scan, **options)
    with pytest.raises(tr.Error, match="source"):
        tr.Operation.open(3)
    with pytest.raises(TypeError, match="Operation.open"):
        tr.Operation()
    operation = tr.Operation.open(scan, iso=300)
    positions = path_down(3)
    for buttons in (0.5, np.array([1.0, 0.0, 1.0]), -1, [1, -1, 0], [0, 1], 2**40, "yes"):
        with pytest.raises(tr.Error, match="buttons"):
            operation.run(positions, buttons=buttons)
    operation.run(positions, buttons=True)
    operation.run(positions, buttons=np.array([True, False, True]))
    with pytest.raises(tr.Error, match="orientations, pose 1"):
        operation.run(positions, orientations=np.array([[1, 0, 0, 0], [2, 0, 0, 0], [1, 0, 0, 0]], float))
    with pytest.raises(tr.Error, match="low"):
        operation.read((0.5, 0, 0), (3, 3, 3))
    with pytest.raises(tr.Error, match="high"):
        operation.read((0, 0, 0), (np.inf, 3, 3))
    for value in (None, b"4", object(), {1: 2}):
        with pytest.raises(tr.Error, match="diameter"):
            operation.command("burr", diameter=value)
    with pytest.raises(tr.Error, match="hand"):
        operation.command("burr", hand="left")
    with pytest.raises(tr.Error, match="radius"):
        tr.Scan.phantom("sphere", radius="large")


def test_parameters_may_be_numpy_scalars():
    operation = tr.Operation.open(sphere((5, 5, 5)), iso=300, hand=tr.Hand(radius=1.5))
    for value in (np.float32(4), np.float64(4), np.int64(4), 4):
        operation.command("burr", diameter=value, round=np.bool_(True))
    assert repr(tr.Hand("burr", diameter=np.int16(4))) == repr(tr.Hand("burr", diameter=4))


def test_a_session_of_an_array_is_reopened_with_its_scan(tmp_path):
    voxels = np.full((40, 40, 40), -1000, np.int16)
    voxels[:20] = 1000
    scan = tr.Scan(voxels, spacing=(1, 1, 1), hounsfield=True)
    assert scan.is_hounsfield and not tr.Scan(voxels, spacing=(1, 1, 1)).is_hounsfield
    path = tmp_path / "a.session"
    hand = tr.Hand("burr", diameter=5, removal_rate=100)
    operation = tr.Operation.open(scan, hand=hand, iso=300, record=path)
    positions = np.full((800, 3), 20.0)
    positions[:, 2] = 30 - 0.02 * np.arange(800)
    operation.run(positions, buttons=1)
    assert operation.removed_mm3 > 10
    final = operation.hash
    operation.end()
    session = tr.Operation.reopen(path, scan)
    assert session.is_whole
    session.verify()
    session.go_to(800)
    assert session.hash == final
    with pytest.raises(tr.Error):
        tr.Operation.reopen(path)
    with pytest.raises(tr.Error):  # another scan
        tr.Operation.reopen(path, tr.Scan(voxels + np.int16(1), spacing=(1, 1, 1), hounsfield=True))
    # A file that lacks its end opens with a warning.
    data = path.read_bytes()
    short = tmp_path / "short.session"
    short.write_bytes(data[: len(data) * 2 // 3])
    with pytest.warns(UserWarning, match="lost"):
        session = tr.Operation.reopen(short, scan)
    assert not session.is_whole

def test_arrays_too_large_are_refused():
    with pytest.raises(tr.Error, match="size of a scan"):
        tr.Scan(np.broadcast_to(np.int16(0), (40000, 2, 2)), spacing=(1, 1, 1))
    with pytest.raises(tr.Error, match="memory"):
        tr.Scan(np.broadcast_to(np.int16(0), (20000,) * 3), spacing=(1, 1, 1))
    operation = tr.Operation.open(sphere((5, 5, 5)), iso=300)
    with pytest.raises(tr.Error, match="memory"):
        operation.run(np.broadcast_to(np.zeros(3), (10**12, 3)))


def test_a_parameter_may_be_called_name():
    operation = tr.Operation.open(sphere((5, 5, 5)), iso=300)
    operation.command("begin-branch", name="other")


def test_pickling_is_refused_with_a_message():
    scan = sphere((5, 5, 5))
    for value in (scan, tr.Operation.open(scan)):
        with pytest.raises(TypeError, match="pickled"):
            pickle.dumps(value)


def test_one_thread_at_a_time():
    operation = tr.Operation.open(sphere(), iso=300)
    positions = path_down(1000)
    failures = []

    def play():
        for _ in range(200):
            try:
                operation.run(positions)
            except RuntimeError as error:
                failures.append(str(error))

    threads = [threading.Thread(target=play) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    # A call during another call is refused with a message.
    assert all("another thread" in text for text in failures)
    assert operation.tick == 1000 * (400 - len(failures))


def test_no_memory_is_lost_over_many_operations():
    scan = sphere((4, 4, 4))
    positions = path_down(50)

    def resident_mb():
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * 4096 / 1e6

    for _ in range(20):
        tr.Operation.open(scan, iso=300).run(positions)
    before = resident_mb()
    for _ in range(200):
        tr.Operation.open(scan, iso=300).run(positions)
    gc.collect()
    assert resident_mb() - before < 20


def test_import_loads_no_windows():
    code = "import trephine; print(open('/proc/self/maps').read())"
    maps = subprocess.run(["/usr/bin/python3", "-c", code], check=True, capture_output=True, text=True).stdout
    assert "_core.so" in maps
    assert "libQt5" not in maps and "libvtkRenderingOpenGL" not in maps


def test_a_forked_process_gets_an_error():
    operation = tr.Operation.open(sphere((3, 3, 3)), iso=300)
    child = os.fork()
    if child == 0:
        try:
            operation.run([[0, 0, 60]])
        except RuntimeError as error:
            os._exit(7 if "after the fork" in str(error) else 8)
        os._exit(9)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7


def test_ctrl_c_ends_a_run():
    operation = tr.Operation.open(sphere((3, 3, 3)), iso=300)
    threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(1000):
            operation.run(np.tile((0.0, 0.0, 28.0), (500_000, 1)))
    assert operation.tick % 500_000 != 0  # the last call did not end
    operation.run([[0, 0, 60]])


def test_faults_and_limits_are_named():
    operation = tr.Operation.open(sphere((3, 3, 3)), iso=300)
    touches = operation.run([[0, 0, 60], [np.nan, 0, 0]])
    assert tr.Fault(int(touches.faults[1])) & tr.Fault.NOT_FINITE and touches.faults[0] == 0
    assert operation.hand_count == 1 and operation.rate == 1000
    with pytest.raises(tr.Error, match="0 to 0"):
        operation.explain_force(0, hand=4)
    with pytest.raises(tr.Error, match="are equal"):
        tr.MeasuredValue("width", 1, full_at=1, zero_at=1)
    with pytest.raises(tr.Error, match="path of the session is empty"):
        tr.Operation.open(sphere((3, 3, 3)), iso=300, record="")


def test_refusals_differ_from_invalid_commands():
    operation = tr.Operation.open(sphere((3, 3, 3)), iso=300)
    for name, parameters, is_refusal in (("undooo", {}, False), ("note", {"txt": "x"}, False), ("hold-body", {"body": 3}, True)):
        with pytest.raises(tr.Error) as caught:
            operation.command(name, **parameters)
        assert caught.value.is_refusal is is_refusal, name


def test_an_operation_names_its_scan_structures_and_plan():
    operation = tr.Operation.open("spine", plan=True)
    scan = operation.scan
    assert np.shares_memory(scan.array, operation.array) and scan.spacing == operation.spacing
    assert np.allclose(scan.voxel(scan.world(np.array([[1.0, 2.0, 3.0]]))), [[1, 2, 3]])
    assert "L4" in scan.label_names
    entry, target = operation.trajectories["L4 left pedicle"]
    assert 40 < np.linalg.norm(np.subtract(entry, target)) < 60
    top = np.tile((0.0, 60.0, 0.0), (600, 1))
    top[:, 1] = np.linspace(75, 50, 600)
    touches = operation.run(top)
    touched = {operation.item_names[i] for i in touches.item[touches.contact]}
    assert touched == {"bone"}
    assert all(len(position) == 3 for position in operation.landmarks.values())
    array = scan.array
    del operation, scan
    gc.collect()
    assert array.min() < array.max()
