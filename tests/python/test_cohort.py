"""trephine-cohort with a stand-in for the command, and one case with the command itself."""

import csv
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
COHORT = ROOT / "apps/cohort/trephine-cohort"

# A stand-in that prints results as `trephine run` and `trephine score` do. Seed 3 fails, seed 4 crashes, seed 5
# sleeps for 60 s, seed 6 prints an unknown result, seed 7 is killed; seed 8 is killed the first time.
STAND_IN = f"#!{sys.executable} -SE" + """
import json, os, sys, time
words = sys.argv[1:]
commit = os.environ.get("COMMIT", "abc")
if words[0] == "run":
    seed, skill = int(words[words.index("--seed") + 1]), words[words.index("--skill") + 1]
    if seed == 3:
        print(json.dumps({"commit": commit, "error": {"what": "the scan is missing"}}))
        sys.exit(2)
    if seed == 4:
        os.kill(os.getpid(), 11)
    if seed == 6:
        print("[1]")
        sys.exit()
    if seed == 7 or seed == 8 and not os.path.exists("killed"):
        open("killed", "w")
        os.kill(os.getpid(), 9)
    if seed == 5 or skill == "expert" and "HOLD" in os.environ:
        time.sleep(60)
    open(words[words.index("--record") + 1], "w").write(f"{skill} {seed}")
    print(json.dumps({"commit": commit, "title": "A drill", "removed_mm3_total": 2.5, "content_hash": f"h{seed}"}))
else:
    skill, seed = open(words[1]).read().split()
    points = {"novice": 4, "trained": 6, "expert": 9}[skill] + 0.1 * int(seed)
    print(json.dumps({"points": points, "possible": 10, "not_judged": 0, "seconds": 12.0,
                      "findings": [{"name": "dura: torn", "value": 0, "verdict": "good"},
                                   {"name": "depth", "value": points,
                                    "verdict": "good" if points > 9 else "fair" if points > 6 else "bad"}]}))
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    stand_in = tmp_path / "trephine"
    stand_in.write_text(STAND_IN)
    stand_in.chmod(0o755)
    (tmp_path / "drill.toml").write_text("title = 'A drill'\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def cohort(*words):
    return subprocess.run([sys.executable, COHORT, *words], capture_output=True, text=True)


def run(results, *words):
    return cohort("run", "plan.csv", results, "--trephine", "./trephine", *words)


def plan(seeds, *words):
    assert cohort("plan", "drill.toml", "--seeds", str(seeds), "-o", "plan.csv", *words).returncode == 0


def table_of(results):
    merged = cohort("merge", "plan.csv", results, "-o", f"{results}.csv", "--picture", f"{results}.svg",
                    "--heat-map", f"{results}-verdicts.svg")
    assert merged.returncode == 0, merged.stderr
    return merged.stdout.splitlines()[-1]


def test_parts_and_cores_give_the_same_table(place):
    plan(2)
    assert run("one", "--cores", "1").returncode == 0
    for part in ("2/3", "1/3", "3/3"):
        assert run("parts", "--cores", "4", "--part", part).returncode == 0
    assert table_of("one") == table_of("parts")
    rows = list(csv.DictReader(open("one.csv")))
    assert [row["skill"] for row in rows] == ["novice"] * 2 + ["trained"] * 2 + ["expert"] * 2
    assert rows[4]["points"] == "9.1" and rows[4]["depth"] == "9.1" and rows[0]["dura: torn"] == "0"
    assert Path("one.svg").read_text().count("<circle") == 6
    # The heat map has a cell per finding and case, and four in its legend. Each colour occurs as often as its
    # verdict, and once more in the legend.
    cells = Path("one-verdicts.svg").read_text()
    assert cells.count("<rect x=") == 2 * 6 + 4
    assert [cells.count(f'fill="{color}"/>') - 1 for color in ("#d5e5d8", "#f0c75e", "#c0392b")] == [8, 2, 2]
    assert not [name for name in os.listdir("one") if name.startswith("work") or name.endswith("part")]
    assert not Path("one/sessions").exists()


def test_failed_cases_are_rows_with_an_error(place):
    plan(4, "--skills", "novice")
    assert run("results").returncode == 0
    table_of("results")
    errors = [row["error"] for row in csv.DictReader(open("results.csv"))]
    assert errors == ["", "", "the scan is missing", "trephine run ended with -11"]
    Path("plan.csv").write_text("case,script,skill,seed\n1,drill.toml,novice,5\n")
    assert run("late", "--timeout", "1").returncode == 0
    table_of("late")
    (row,) = csv.DictReader(open("late.csv"))
    assert row["error"] == "trephine run took longer than 1 s"


def test_a_killed_case_is_run_once_more(place):
    Path("plan.csv").write_text("\ufeffcase,script,skill,seed\n" + "".join(f"{s},drill.toml,novice,{s}\n" for s in (6, 7, 8)))
    ran = run("results")
    assert ran.returncode == 0 and "1 failed: trephine was killed twice" in ran.stderr
    table_of("results")
    errors = [row["error"] for row in csv.DictReader(open("results.csv"))]
    assert errors == ["trephine run printed an unknown result", "trephine was killed twice, perhaps for lack of memory", ""]


def test_a_signal_to_all_processes_stops_the_run(place, monkeypatch):
    # Commands that the signal ends by itself, at about the time at which the run kills them, do not hold up its end,
    # and are no results.
    monkeypatch.setenv("HOLD", "")
    plan(2, "--skills", "expert")
    for i in range(12):
        process = subprocess.Popen([sys.executable, COHORT, "run", "plan.csv", "results", "--trephine", "./trephine",
                                    "--cores", "4"], stderr=subprocess.PIPE, start_new_session=True)
        time.sleep(0.1 + 0.03 * i)
        os.killpg(process.pid, (signal.SIGTERM, signal.SIGHUP)[i % 2])
        errors = process.communicate(timeout=20)[1]
        assert process.returncode in (130, -signal.SIGTERM, -signal.SIGHUP) and b"Traceback" not in errors, errors
        assert not list(Path("results").glob("0*.json"))


def test_plans_written_by_hand_are_checked(place):
    run_words = ["run", "plan.csv", "results", "--trephine", "./trephine"]
    for rows, problem in [
        ("1,drill.toml,novice,1\n2,drill.toml,novice,01\n", "the same script, skill and seed"),
        ("1\n", "line 2 of the plan lacks a value"),
        ("1,drill.toml,novice,1.0\n", "a whole number"),
        ("1,drill.toml,master,1\n", "unknown skill 'master'"),
    ]:
        Path("plan.csv").write_text("case,script,skill,seed\n" + rows)
        result = cohort(*run_words)
        assert result.returncode == 2 and problem in result.stderr, result.stderr
    Path("plan.csv").write_text("case;script;skill;seed\n1;drill.toml;novice;1\n")
    result = cohort(*run_words)
    assert result.returncode == 2 and "'case;script;skill;seed'" in result.stderr, result.stderr


def test_a_changed_scan_is_noticed_and_not_replaced(place):
    Path("drill.toml").write_text("title = 'A drill'\nscan = 'own.mha'\n")
    Path("own.mha").write_text("one")
    plan(1)
    assert run("results").returncode == 0
    for output in ("own.mha", "drill.toml"):
        merged = cohort("merge", "plan.csv", "results", "-o", output)
        assert merged.returncode == 2 and "would replace" in merged.stderr
    Path("own.mha").write_text("two")
    again = run("results")
    assert again.returncode == 2 and "another script, scan" in again.stderr
    Path("results/00001.json").write_text("[1]")
    assert "is damaged" in run("results").stderr
    Path("file").write_text("")
    result = run("file")
    assert result.returncode == 2 and "cannot be written" in result.stderr, result.stderr


def test_a_killed_run_continues(place, monkeypatch):
    plan(2)
    run("whole")
    for kill, status in ((signal.SIGKILL, -signal.SIGKILL), (signal.SIGTERM, 130)):
        results = f"killed{kill}"
        monkeypatch.setenv("HOLD", "")  # the last two cases sleep, so that the run is killed before its end
        process = subprocess.Popen([sys.executable, COHORT, "run", "plan.csv", results, "--trephine", "./trephine",
                                    "--cores", "1"], stderr=subprocess.DEVNULL)
        while not list(Path(results).glob("0*.json")):
            time.sleep(0.01)
        process.send_signal(kill)
        assert process.wait() == status
        monkeypatch.delenv("HOLD")
        ready = {path: path.stat().st_mtime_ns for path in Path(results).glob("0*.json")}
        assert 1 <= len(ready) <= 4
        assert run(results).returncode == 0
        assert all(path.stat().st_mtime_ns == written for path, written in ready.items())  # not run again
        assert table_of(results) == table_of("whole")


def test_results_of_another_script_or_version_are_refused(place, monkeypatch):
    plan(1)
    merged = cohort("merge", "plan.csv", "results", "-o", "table.csv")
    assert merged.returncode == 2 and "3 of 3 cases were not run" in merged.stderr
    run("results", "--part", "1/3")
    monkeypatch.setenv("COMMIT", "def")
    run("results")
    merged = cohort("merge", "plan.csv", "results", "-o", "table.csv")
    assert merged.returncode == 2 and "2 versions of trephine" in merged.stderr
    (place / "drill.toml").write_text("title = 'Another drill'\n")
    again = run("results")
    assert again.returncode == 2 and "belongs to another script" in again.stderr
    assert not Path("table.csv").exists()


def test_mistakes_are_reported_without_a_traceback(place):
    plan(1)
    for words, problem in [
        (["plan", "none.toml", "-o", "new.csv"], "does not exist"),
        (["plan", "drill.toml", "-o", "plan.csv"], "exists already"),
        (["plan", "drill.toml", "-o", "new.csv", "--skills", "master"], "unknown skill"),
        (["run", "none.csv", "results"], "cannot be read"),
        (["run", "drill.toml", "results"], "lacks the columns"),
        (["run", "plan.csv", "results", "--trephine", "./none"], "was not found"),
        (["run", "plan.csv", "results", "--trephine", "./trephine", "--part", "4/3"], "out of range"),
        (["run", "plan.csv", "results", "--trephine", "./trephine", "--part", "x"], "whole number"),
        (["merge", "plan.csv", "results", "-o", "plan.csv"], "would replace"),
        (["merge", "plan.csv", "results", "-o", "t.csv", "--picture", "t.csv"], "would replace"),
        (["merge", "plan.csv", "results", "-o", "results/00001.json"], "would replace"),
    ]:
        result = cohort(*words)
        assert result.returncode == 2 and problem in result.stderr and "Traceback" not in result.stderr, result.stderr


@pytest.mark.skipif("TREPHINE_COMMAND" not in os.environ, reason="the command was not built")
@pytest.mark.skipif("TREPHINE_WHOLE" not in os.environ, reason="longer than 5 s")
def test_a_case_with_the_command_itself(place):
    script = ROOT / "docs/examples/procedure-laminectomy-screws.toml"
    assert cohort("plan", script, "--skills", "expert", "--seeds", "1", "-o", "plan.csv").returncode == 0
    ran = cohort("run", "plan.csv", "results", "--keep-sessions", "--trephine", os.environ["TREPHINE_COMMAND"])
    assert ran.returncode == 0, ran.stderr
    table_of("results")
    (row,) = csv.DictReader(open("results.csv"))
    assert row["error"] == "" and 0 < float(row["points"]) <= float(row["possible"])
    assert float(row["L4 left: breach"]) < 2
    assert Path("results/sessions/00001.session").exists()


@pytest.mark.skipif("TREPHINE_COMMAND" not in os.environ, reason="the command was not built")
def test_a_script_on_an_own_scan_is_scored(place):
    command = os.environ["TREPHINE_COMMAND"]
    subprocess.run([command, "phantom", "sphere", "--spacing", "2", "-o", "ball.mha"], check=True, stdout=subprocess.DEVNULL)
    (place / "own.toml").write_text("""schema = 1
title = "A short drill"
scan = "ball.mha"
iso = 300
[[hands]]
instrument = "burr"
parameters = "diameter=6"
points = [[0, 0, 0, 60, 0], [0.5, 0, 0, 40, 1], [1, 0, 0, 30, 1]]
""")
    assert cohort("plan", "own.toml", "--skills", "expert", "--seeds", "1", "-o", "plan.csv").returncode == 0
    assert cohort("run", "plan.csv", "results", "--trephine", command).returncode == 0
    table_of("results")
    (row,) = csv.DictReader(open("results.csv"))
    assert row["error"] == "" and float(row["removed_mm3"]) > 1
