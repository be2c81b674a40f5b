import http.client
import os
import threading

import pytest
from shown_results import write_results

from experiments.reports.show.results import open_results
from experiments.reports.show.server import ADDRESS, Show, server


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    outside = tmp_path_factory.mktemp("around")
    (outside / "secret.txt").write_text("secret")
    inside = outside / "results"
    inside.mkdir()
    write_results(inside)
    os.symlink(outside / "secret.txt", inside / "link.txt")
    (inside / ".hidden").write_text("secret")
    return inside


@pytest.fixture(scope="module")
def show(folder):
    return Show(open_results(folder))


@pytest.fixture(scope="module")
def port(folder):
    serving, _ = server(open_results(folder))
    thread = threading.Thread(target=serving.serve_forever)
    thread.start()
    yield serving.server_address[1]
    serving.shutdown()
    thread.join()
    serving.server_close()


def ask(port, target, *, method="GET", host=None):
    connection = http.client.HTTPConnection(ADDRESS, port, timeout=10)
    connection.putrequest(method, target, skip_host=True)
    for name in (f"{ADDRESS}:{port}",) if host is None else host:
        connection.putheader("Host", name)
    connection.endheaders()
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer, body


def test_the_overview_offers_every_file_and_page(show):
    text = show.answer("/").body.decode()
    for address in ("/report", "/runs", "/plan", "/files/export/controller.csv"):
        assert f'href="{address}"' in text


def test_a_file_comes_as_it_is_to_be_kept(port):
    answer, body = ask(port, "/files/export/controller.csv")
    assert (answer.status, body) == (200, b"a,b\n1,2\n")
    assert answer.headers["Content-Disposition"] == 'attachment; filename="controller.csv"'


@pytest.mark.parametrize(
    "path",
    [
        "../secret.txt",
        "%2e%2e/secret.txt",
        "..%2fsecret.txt",
        "export/../../secret.txt",
        "//etc/passwd",
        "%2fetc%2fpasswd",
        "link.txt",
        ".hidden",
        "export",
        "",
        "report.html%00",
    ],
)
def test_nothing_outside_of_the_folder_is_given(port, path):
    answer, body = ask(port, f"/files/{path}")
    assert answer.status == 404
    assert b"secret" not in body.replace(path.encode(), b"")


@pytest.mark.parametrize(
    "host", [(), ("evil.example",), ("127.0.0.1",), ("127.0.0.1:1",), ("localhost:0", "a")]
)
def test_whoever_asks_by_another_name_is_refused(port, host):
    answer, body = ask(port, "/", host=host)
    assert answer.status == 403
    assert b"overview" not in body.lower()


def test_this_machine_may_be_called_localhost(port):
    assert ask(port, "/", host=(f"localhost:{port}",))[0].status == 200


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "HEAD", "OPTIONS"])
def test_nothing_but_reading_is_answered(port, method):
    assert ask(port, "/", method=method)[0].status == 501


def test_a_page_runs_no_script_but_its_own(port):
    policy = ask(port, "/plan")[0].headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "script-src 'self'" in policy
    assert ask(port, "/show.js")[0].headers["Content-Type"].startswith("text/javascript")


def test_a_run_is_chosen_by_its_name(show):
    assert "Run 0001-manoeuvre" in show.answer("/runs").body.decode()
    assert "Run 0002-manoeuvre" in show.answer("/runs?run=0002-manoeuvre").body.decode()


def test_a_name_from_an_address_is_text(show):
    answer = show.answer("/runs?run=%3Cscript%3E")
    assert answer.status == 400
    assert b"<script>" not in answer.body


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ("x=nan", "expected a number"),
        ("time=1e9", "outside of what can be chosen"),
        ("x=1&to_x=1&y=0.5&to_y=0.5", "there is no leg"),
        ("setting=77", "no fitted robot at 77 N"),
    ],
)
def test_a_leg_that_is_none_is_told_on_the_page(show, query, words):
    for page in ("/plan/leg", "/plan.csv"):
        answer = show.answer(f"{page}?{query}")
        assert answer.status == 400
        assert words in answer.body.decode()


def test_a_folder_without_a_tuning_plans_nothing(tmp_path):
    write_results(tmp_path)
    (tmp_path / "tuning.json").unlink()
    shown = Show(open_results(tmp_path))
    assert shown.answer("/plan").status == 404
    assert b'href="/plan"' not in shown.answer("/").body


def test_a_folder_without_results_is_refused_with_a_remedy(tmp_path):
    with pytest.raises(ValueError, match="Run `scdpr calibrate"):
        open_results(tmp_path)
    with pytest.raises(ValueError, match="no such folder"):
        open_results(tmp_path / "none")
