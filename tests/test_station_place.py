"""Where the station listens: addresses, and TLS by the files of its owner."""

from __future__ import annotations

import shutil
import ssl
import subprocess
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from station_rig import Page, frame_at, serving, shared_by
from strategies import examples

from scara_drake.station.place import Place

openssl = pytest.mark.skipif(shutil.which("openssl") is None, reason="openssl makes the files")


def certificate(folder: Path) -> tuple[Path, Path]:
    cert, key = folder / "cert.pem", folder / "key.pem"
    command = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "1"]
    names = ["-subj", "/CN=localhost", "-addext", "subjectAltName=IP:127.0.0.1"]
    files = ["-keyout", str(key), "-out", str(cert)]
    subprocess.run([*command, *names, *files], check=True, capture_output=True)
    return cert, key


@openssl
def test_with_a_certificate_the_page_is_served_over_tls(tmp_path: Path) -> None:
    cert, key = certificate(tmp_path)
    trusting = ssl.create_default_context(cafile=str(cert))
    with serving(Place(tls_cert=cert, tls_key=key), "joint_sine") as station:
        assert station.address.startswith("https://127.0.0.1:")
        with Page(station.address, ssl=trusting) as page:
            assert page.hears("hello")["scenario"] == "joint_sine"
            shared_by(station).frame.write(frame_at(1.0))
            assert page.hears("telemetry")["t"] == 1.0
        with pytest.raises(Exception, match=r"HTTP|EOF|reset|closed|response"):
            Page(station.address.replace("https", "http"))


@openssl
def test_tls_files_that_do_not_belong_together_are_refused(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
    cert, _ = certificate(tmp_path / "a")
    _, key = certificate(tmp_path / "b")
    for wrong in (key, cert, tmp_path / "none.pem", tmp_path):
        with pytest.raises(ValueError, match=r"^tls: '.*', '.*', allowed a certificate") as error:
            Place(tls_cert=cert, tls_key=wrong)
        assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("host", "local"),
    [
        ("127.0.0.1", True),
        ("localhost", True),
        ("::1", True),
        ("127.9.9.9", True),
        ("*", False),
        ("0.0.0.0", False),  # nobody listens there
        ("192.0.2.7", False),
        ("example.org", False),
    ],
)
def test_who_reaches_it_is_known(host: str, local: bool) -> None:
    assert Place(host=host).is_local is local


def test_the_address_can_be_opened() -> None:
    assert Place().address(8000, "word") == "http://127.0.0.1:8000/word/"
    assert Place("::1").address(8000, "word") == "http://[::1]:8000/word/"
    for everywhere in ("*", "0.0.0.0", "::"):  # nobody listens there
        shown = Place(everywhere).address(8000, "word")
        assert "0.0.0.0" not in shown  # no address to connect to
        assert "[::]" not in shown


@examples(50)
@given(st.integers().filter(lambda port: not 0 <= port <= 65535))
def test_a_port_out_of_bounds_is_refused(port: int) -> None:
    with pytest.raises(ValueError, match=r"^port: "):
        Place(port=port)
