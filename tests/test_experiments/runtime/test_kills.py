"""A call that is killed at whatever moment goes on to the same bytes, and leaves nothing."""

import os
import subprocess
import sys

import pytest
from given_files import write_results

from experiments.virtual_rig.recovery import campaign, draw
from identification.campaign import write_campaign

KILLS = '''
"""Kill a command again and again: in processes forked from one that has imported all."""
import hashlib, os, pathlib, random, shutil, signal, sys, time
import experiments.cli as cli
import experiments.sweep.run, experiments.sweep.show, experiments.verbs.study.sweep
import experiments.studies.campaigns.run, experiments.verbs.identification.identify
import experiments.studies.codesign.kept, experiments.verbs.tuning.codesign
import experiments.studies.legs.many_legs, experiments.verbs.tuning.plan
import experiments.virtual_rig.__main__, experiments.virtual_rig.monte_carlo

root, kills, seed, *command = sys.argv[1:]
root, left = pathlib.Path(root), int(kills)
random.seed(int(seed))
verb, main = command[0], cli.main
if verb == "recovery":
    main = experiments.virtual_rig.__main__.main
    command = command[1:]


def begin(out):
    process = os.fork()
    if process == 0:
        silent = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silent, 1), os.dup2(silent, 2)
        os._exit(main([word.replace("OUT", str(out)) for word in command]))
    return process


def ended(process, seconds):
    """Its exit status; None if it still runs then."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        if os.waitpid(process, os.WNOHANG)[0]:
            return True
        time.sleep(0.003)
    return False


def contents(out):
    files = sorted(path for path in out.rglob("*") if path.is_file())
    # A picture is drawn after the file that it shows, and says nothing more.
    files = [path for path in files if path.suffix != ".png"]
    return {str(f.relative_to(out)): hashlib.sha256(f.read_bytes()).hexdigest() for f in files}


def whole(name):
    out = root / name
    out.mkdir()
    begun = time.monotonic()
    os.waitpid(begin(out), 0)
    return contents(out), time.monotonic() - begun


whole("first")  # compiles
expected, lasts = whole("second")
done = 0
while left > 0:
    out = root / f"out-{done}"
    out.mkdir()
    while True:
        process = begin(out)
        # Now and then it may end: what keeps nothing on the way would hardly ever.
        if ended(process, random.uniform(0, lasts) if random.random() < 0.8 else 1e4):
            break
        os.kill(process, signal.SIGKILL)
        os.waitpid(process, 0)
        left -= 1
        names = {path.name for path in out.iterdir()}
        unfinished = {name for name in names if name.endswith(".unfinished")}
        scratch = {name for name in names - unfinished if name.startswith(".")}
        assert not scratch, scratch
        # Among what is unfinished a file may have a name already: the next call clears it away.
        scratch = [file.relative_to(out).parts for file in out.rglob(".scdpr-*")]
        assert all(unfinished & {*parts} for parts in scratch), scratch
        if names and not unfinished and contents(out).keys() == expected.keys():
            break  # killed as it said what it had done
        lasts *= 1.02  # Where others take the machine, it ends all the same.
    assert contents(out) == expected, set(contents(out)) ^ set(expected)
    shutil.rmtree(out)
    done += 1
print(done)
'''


def killed(tmp_path, kills, *command, seed=1):
    script = tmp_path / "kills.py"
    script.write_text(KILLS)
    (tmp_path / "out").mkdir()
    out = str(tmp_path / "out")
    call = [sys.executable, str(script), out, str(kills), str(seed), *command]
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache")}
    done = subprocess.run(call, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 0


nameless = pytest.mark.skipif(
    not hasattr(os, "O_TMPFILE"), reason="no files without a name here"
)


@pytest.mark.slow
@nameless
def test_a_sweep_survives_forty_kills(tmp_path):
    over = ("y=0.2..0.9:300 m", "effective_pretension=50..300:700 N")
    killed(tmp_path, 40, "sweep", "frequency", "--over", *over, "--out", "OUT/out.nc")


@pytest.mark.slow
@nameless
def test_a_batch_survives_thirty_kills(tmp_path):
    for seed in range(2):
        write_campaign(campaign(draw(seed), seed), tmp_path / "rigs" / f"rig-{seed}")
    (tmp_path / "rigs" / "bad").mkdir()
    (tmp_path / "rigs" / "bad" / "campaign.toml").write_text("no = 1")
    killed(tmp_path, 30, "identify", str(tmp_path / "rigs"), "--out", "OUT", "--cores", "1")


@pytest.mark.slow
@nameless
def test_a_monte_carlo_of_fits_survives_ten_kills(tmp_path):
    killed(tmp_path, 10, "recovery", "--campaigns", "4", "--out", "OUT/out.csv")


@pytest.mark.slow
@nameless
def test_a_co_design_survives_ten_kills(tmp_path):
    write_results(tmp_path)
    small = ("--grid", "1x2", "--samples", "1", "--move-times", "2.3 s", "2.9 s")
    given = str(tmp_path / "parameters.json")
    killed(tmp_path, 10, "codesign", given, *small, "--out", "OUT")


@pytest.mark.slow
@nameless
def test_many_legs_survive_ten_kills(tmp_path):
    write_results(tmp_path)
    ends = [0.5 + 0.04 * number for number in range(33)]
    rows = ["x_from [m],y_from [m],x_to [m],y_to [m],leg_time [s]"]
    rows += [f"0.3,0.55,{end:.2f},0.45,1.8" for end in ends]
    legs = tmp_path / "legs.csv"
    legs.write_text("\n".join(rows) + "\n")
    killed(
        tmp_path, 10, "plan", str(tmp_path / "tuning.json"), "--legs", str(legs), "--out", "OUT"
    )
