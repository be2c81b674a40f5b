"""A call that is killed at whatever moment goes on to the same bytes, and leaves nothing."""

import os
import subprocess
import sys

import pytest

from experiments.virtual_rig.recovery import campaign, draw
from identification.campaign import write_campaign

KILLS = '''
"""Kill a command again and again: in processes forked from one that has imported all."""
import hashlib, os, pathlib, random, shutil, signal, sys, time
import experiments.cli as cli
import experiments.sweep.run, experiments.sweep.show, experiments.verbs.study.sweep
import experiments.studies.campaigns.run, experiments.verbs.identification.identify

root, kills, *command = sys.argv[1:]
root, left = pathlib.Path(root), int(kills)
random.seed(1)


def begin(out):
    process = os.fork()
    if process == 0:
        silent = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silent, 1), os.dup2(silent, 2)
        os._exit(cli.main([word.replace("OUT", str(out)) for word in command]))
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
        if ended(process, random.uniform(0, lasts)):
            break
        os.kill(process, signal.SIGKILL)
        os.waitpid(process, 0)
        left -= 1
        names = {path.name for path in out.iterdir()}
        unfinished = {name for name in names if name.endswith(".unfinished")}
        scratch = {name for name in names - unfinished if name.startswith(".")}
        assert not scratch, scratch
        if names and not unfinished and contents(out).keys() == expected.keys():
            break  # killed as it said what it had done
        lasts *= 1.02  # Where others take the machine, it ends all the same.
    assert contents(out) == expected, set(contents(out)) ^ set(expected)
    shutil.rmtree(out)
    done += 1
print(done)
'''


def killed(tmp_path, kills, *command):
    script = tmp_path / "kills.py"
    script.write_text(KILLS)
    (tmp_path / "out").mkdir()
    call = [sys.executable, str(script), str(tmp_path / "out"), str(kills), *command]
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache")}
    done = subprocess.run(call, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 0


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "O_TMPFILE"), reason="no files without a name here")
def test_a_sweep_survives_forty_kills(tmp_path):
    over = ("y=0.2..0.9:300 m", "effective_pretension=50..300:700 N")
    killed(tmp_path, 40, "sweep", "frequency", "--over", *over, "--out", "OUT/out.nc")


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "O_TMPFILE"), reason="no files without a name here")
def test_a_batch_survives_thirty_kills(tmp_path):
    for seed in range(2):
        write_campaign(campaign(draw(seed), seed), tmp_path / "rigs" / f"rig-{seed}")
    (tmp_path / "rigs" / "bad").mkdir()
    (tmp_path / "rigs" / "bad" / "campaign.toml").write_text("no = 1")
    killed(tmp_path, 30, "identify", str(tmp_path / "rigs"), "--out", "OUT", "--cores", "1")
