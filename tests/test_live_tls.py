"""Encrypted sources: a certificate that is trusted is taken, another is refused in one line."""

from __future__ import annotations

import gc
import shutil
import ssl
import subprocess
import warnings
from pathlib import Path

import numpy as np
import pytest
from tests.live_reading import read_some
from tests.live_servers import SocketServer
from tests.test_live_mqtt import broker, needs_broker

from varishold.errors import InputError
from varishold.live import source_at

OPENSSL = shutil.which("openssl")
pytestmark = pytest.mark.skipif(OPENSSL is None, reason="openssl is not installed")


@pytest.fixture(scope="module")
def certificate(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("tls")
    made, key = folder / "certificate.pem", folder / "key.pem"
    words = f"req -x509 -newkey rsa:2048 -nodes -keyout {key} -out {made} -days 2 -subj /CN=localhost"
    names = ["-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1"]
    subprocess.run([str(OPENSSL), *words.split(), *names], check=True, capture_output=True)
    return made, key


def test_a_web_socket_is_read_where_its_certificate_is_trusted(
    certificate: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    tls = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    tls.load_cert_chain(*certificate)
    with SocketServer(tls=tls) as server:
        address = f"wss://localhost:{server.port}"
        with pytest.raises(InputError, match=r"its certificate is not trusted \(self-signed certificate\)"):
            source_at(address).open()
        monkeypatch.setenv("SSL_CERT_FILE", str(certificate[0]))
        server.put({"pad": [[1, 2], [3, 4]]})
        source = source_at(address)
        source.open()
        try:
            (sample,) = read_some(source, 1)
        finally:
            source.close()
    np.testing.assert_array_equal(sample.pads["pad"], [[1, 2], [3, 4]])


@needs_broker
def test_a_broker_is_asked_where_its_certificate_is_trusted(
    certificate: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    pytest.importorskip("paho.mqtt.client", reason="paho-mqtt is not installed")
    made, key = certificate
    with broker(tmp_path, settings=f"certfile {made}\nkeyfile {key}\nallow_anonymous true") as port:
        source = source_at(f"mqtts://localhost:{port}/skin")
        with pytest.raises(InputError, match="its certificate is not trusted"):
            source.open()
        with warnings.catch_warnings():
            # paho leaves the socket of a failed handshake to the collector.
            warnings.simplefilter("ignore", ResourceWarning)
            gc.collect()
        monkeypatch.setenv("SSL_CERT_FILE", str(made))
        source.open()
        assert source.read(0.05) == []
        source.close()
