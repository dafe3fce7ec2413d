"""HID devices without hardware, under the real hidapi: run by the system's Python with umockdev.

    /usr/bin/python3 virtual_hid.py SCENARIO.json PROGRAM ARGUMENT...

The scenario names devices and what they do; the program runs with the devices plugged in, and what
it sent to them is printed as JSON. It may be interrupted once it has read all. hidraw nodes are
packet FIFOs (one read, one report, as the kernel has it: umockdev's own terminal merges reports);
libusb devices answer usbdevfs ioctls.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import os
import signal
import struct
import subprocess
import sys
import termios
import threading
import time

import gi

gi.require_version("UMockdev", "1.0")
from gi.repository import UMockdev  # noqa: E402

PCI = "/devices/pci0000:00/0000:00:14.0"
MASK = 0xFFFFFFFF
GRDESCSIZE, GRDESC = 0x80044801, 0x90044802


def usb_code(direction: int, number: int, size: int) -> int:
    return (direction << 30) | (size << 16) | (ord("U") << 8) | number


SUBMIT, REAP, REAP_NOW = usb_code(2, 10, 56), usb_code(1, 12, 8), usb_code(1, 13, 8)
CLAIM, RELEASE, CONFIGURE = usb_code(2, 15, 4), usb_code(2, 16, 4), usb_code(2, 5, 4)
CAPABILITIES, DRIVER, IOCTL = usb_code(2, 26, 4), usb_code(1, 8, 260), usb_code(3, 18, 16)
DISCARD, SPEED = 0x550B, 0x551F


class Device:
    """One device of the scenario: its description, and reports sent to it."""

    def __init__(self, number: int, spec: dict) -> None:
        self.number = number
        self.vid, self.pid = spec["vid"], spec["pid"]
        self.name = spec["name"]
        self.descriptor = bytes.fromhex(spec["descriptor"])
        self.only_usb = spec.get("backend") == "usb"
        self.mode = spec.get("mode", 0o666)
        self.script = spec.get("script", [])
        self.starts = spec.get("starts", "write")
        self.plugged = False
        self.gone = False
        self.started = threading.Event()
        self.written: list[tuple[float, str]] = []

    @property
    def usb(self) -> str:
        return f"{PCI}/usb1/1-{self.number + 2}"

    @property
    def node(self) -> str:
        if self.only_usb:
            return f"/dev/bus/usb/001/{self.number + 2:03d}"
        return f"/dev/hidraw{self.number}"

    def usb_descriptor(self) -> bytes:
        device = struct.pack(
            "<BBHBBBBHHHBBBB", 18, 1, 0x200, 0, 0, 0, 8, self.vid, self.pid, 0x435, 1, 2, 0, 1
        )
        ends = bytes([7, 5, 0x81, 3, 64, 0, 8])
        hid = bytes([9, 0x21, 0x10, 1, 0, 1, 0x22]) + len(self.descriptor).to_bytes(2, "little")
        interface = bytes([9, 4, 0, 0, 1, 3, 0, 0, 0])
        total = 9 + len(interface) + len(hid) + len(ends)
        return (
            device
            + struct.pack("<BBHBBBBB", 9, 2, total, 1, 1, 0, 0x80, 50)[:9]
            + (interface + hid + ends)
        )

    def text(self) -> str:
        """The device as umockdev takes it; without a hidraw child where only libusb sees it."""
        interface = f"{self.usb}/1-{self.number + 2}:1.0"
        hid = f"{interface}/0003:{self.vid:04X}:{self.pid:04X}.{self.number + 1:04X}"
        bus = f"bus/usb/001/{self.number + 2:03d}"
        whole = self.usb_descriptor().hex().upper()
        raw = (
            ""
            if self.only_usb
            else f"""P: {hid}/hidraw/hidraw{self.number}
N: hidraw{self.number}
E: DEVNAME=/dev/hidraw{self.number}
E: MAJOR=240
E: MINOR={self.number}
E: SUBSYSTEM=hidraw
A: dev=240:{self.number}\\n
L: device=../../../0003:{self.vid:04X}:{self.pid:04X}.{self.number + 1:04X}

P: {hid}
E: DRIVER=hid-generic
E: HID_ID=0003:{self.vid:08X}:{self.pid:08X}
E: HID_NAME=virtual {self.name}
E: HID_PHYS=usb-0000:00:14.0-{self.number + 2}/input0
E: HID_UNIQ=
E: SUBSYSTEM=hid
H: report_descriptor={self.descriptor.hex().upper()}

"""
        )
        return f"""{raw}P: {interface}
E: DEVTYPE=usb_interface
E: DRIVER=usbhid
E: PRODUCT={self.vid:x}/{self.pid:x}/435
E: INTERFACE=3/0/0
E: SUBSYSTEM=usb
A: bAlternateSetting= 0\\n
A: bInterfaceClass=03\\n
A: bInterfaceNumber=00\\n
A: bInterfaceProtocol=00\\n
A: bInterfaceSubClass=00\\n
A: bNumEndpoints=01\\n

P: {self.usb}
N: {bus}={whole}
E: DEVNAME=/dev/{bus}
E: DEVTYPE=usb_device
E: DRIVER=usb
E: PRODUCT={self.vid:x}/{self.pid:x}/435
E: BUSNUM=001
E: DEVNUM={self.number + 2:03d}
E: MAJOR=189
E: MINOR={self.number + 1}
E: SUBSYSTEM=usb
A: bConfigurationValue=1\\n
A: bDeviceClass=00\\n
A: bDeviceProtocol=00\\n
A: bDeviceSubClass=00\\n
A: bMaxPacketSize0=8\\n
A: bNumConfigurations=1\\n
A: bNumInterfaces= 1\\n
A: bcdDevice=0435\\n
A: busnum=1\\n
A: devnum={self.number + 2}\\n
A: devpath={self.number + 2}\\n
H: descriptors={whole}
A: dev=189:{self.number + 1}\\n
A: idProduct={self.pid:04x}\\n
A: idVendor={self.vid:04x}\\n
A: manufacturer=virtual\\n
A: product={self.name}\\n
A: speed=12\\n
A: version= 2.00\\n
"""

    def note(self, data: bytes) -> None:
        self.written.append((time.monotonic(), data.hex()))
        self.started.set()


class Host:
    """The testbed with its devices."""

    def __init__(self, devices: list[Device]) -> None:
        self.bed = UMockdev.Testbed.new()
        self.root = self.bed.get_root_dir()
        os.chmod(self.root, 0o755)
        self.devices = devices
        self.keep: list = []
        self.fifos: dict[int, int] = {}
        self.usb: dict[int, UsbNode] = {}

    def plug(self, device: Device) -> None:
        if device.gone:
            device.number += 10  # the testbed takes no node twice
        device.plugged, device.gone = True, False
        self.bed.add_from_string(device.text())
        if device.only_usb:
            self.usb[device.number] = UsbNode(self, device)
            return
        handler = UMockdev.IoctlBase()
        handler.connect("handle-ioctl", lambda _, client: self.on_ioctl(device, client))
        handler.connect("handle-write", lambda _, client: self.on_write(device, client))
        if any(step[1] == "unplug" for step in device.script):
            handler.connect("handle-read", lambda _, client: self.on_read(device, client))
        self.bed.attach_ioctl(device.node, handler)
        self.keep.append(handler)
        self.fifos[device.number] = self.make_fifo(device, 0)

    def make_fifo(self, device: Device, flags: int) -> int:
        node = self.root + device.node
        os.unlink(node)
        os.mkfifo(node)
        end = os.open(node, os.O_RDWR | flags)
        if not flags:
            fcntl.fcntl(end, fcntl.F_SETFL, fcntl.fcntl(end, fcntl.F_GETFL) | os.O_DIRECT)
        os.chmod(node, device.mode)
        return end

    def settle(self, device: Device) -> None:
        """Wait until all that was sent has been read: what is unread goes with the device."""
        while self.is_unread(device):
            time.sleep(0.005)
        time.sleep(0.2)  # who has taken the last report may not have looked at it

    def is_unread(self, device: Device) -> bool:
        if device.only_usb:
            return bool(self.usb[device.number].queue)
        none = b"\0" * 4
        return fcntl.ioctl(self.fifos[device.number], termios.FIONREAD, none) != none

    def unplug(self, device: Device) -> None:
        self.settle(device)
        device.gone, device.plugged = True, False
        if device.only_usb:
            self.usb[device.number].vanish()
        else:
            self.send(device, b"\0")  # wakes the reader, who then learns it
        for path in self.paths(device):
            self.bed.remove_device(path)
        with contextlib.suppress(FileNotFoundError):
            os.unlink(self.root + device.node)

    def paths(self, device: Device) -> list[str]:
        lines = device.text().splitlines()
        return ["/sys" + line[3:] for line in lines if line.startswith("P: ")]

    def send(self, device: Device, report: bytes) -> None:
        if device.only_usb:
            self.usb[device.number].send(report)
        else:
            os.write(self.fifos[device.number], report)

    def play(self, device: Device) -> None:
        """Run a device's script: [at seconds, what, argument] in the order of time."""
        if device.script and device.starts != "now":
            device.started.wait()
        start = time.monotonic()
        for at, what, argument in device.script:
            wait = start + at - time.monotonic()
            if wait > 0:
                time.sleep(wait)
            if what == "send":
                self.send(device, bytes.fromhex(argument))
            elif what == "ramp":
                self.ramp(device, **argument)
            elif what == "unplug":
                self.unplug(device)
            elif what == "plug":
                self.plug(device)
            else:
                raise SystemExit(f"no such step: {what}")

    def ramp(self, device: Device, n: int, hz: float, report: str, stamps: bool = False) -> None:
        """n reports at a rate; {i} in a report's struct arguments counts."""
        layout, *values = json.loads(report)
        start = time.monotonic()
        for i in range(n):
            numbers = [i if v == "i" else i & 0xFFFF if v == "i16" else v for v in values]
            self.send(device, struct.pack(layout, *numbers))
            wait = start + (i + 1) / hz - time.monotonic()
            if wait > 0:
                time.sleep(wait)

    def on_ioctl(self, device: Device, client) -> bool:
        request, argument = client.get_request() & MASK, client.get_arg()
        if device.gone:
            client.complete(-1, errno.ENODEV)
        elif request == GRDESCSIZE:
            argument.resolve(0, 4).update(0, struct.pack("<i", len(device.descriptor)))
            client.complete(0, 0)
        elif request == GRDESC:
            argument.resolve(0, 4100).update(4, device.descriptor)
            client.complete(0, 0)
            if device.starts == "open":
                device.started.set()
        else:
            client.complete(-1, errno.ENOTTY)
        return True

    def on_write(self, device: Device, client) -> bool:
        if device.gone:
            client.complete(-1, errno.ENODEV)
            return True
        data = bytes(client.get_arg().retrieve())
        device.note(data)
        client.complete(len(data), 0)
        return True

    def on_read(self, device: Device, client) -> bool:
        if device.gone:
            client.complete(-1, errno.ENODEV)
        else:
            client.complete(*client.execute())
        return True


class UsbNode:
    """usbdevfs for one device. The node is a FIFO kept full, so that it can be written to (which
    is what libusb waits for) only when a transfer is done."""

    def __init__(self, host: Host, device: Device) -> None:
        self.device = device
        self.lock = threading.RLock()
        self.done: list[dict] = []
        self.waiting: list[dict] = []
        self.queue: list[bytes] = []
        self.strings = {0: b"\x04\x03\x09\x04"}
        for i, text in ((1, "virtual"), (2, device.name)):
            data = text.encode("utf-16le")
            self.strings[i] = bytes([2 + len(data), 3]) + data
        handler = UMockdev.IoctlBase()
        handler.connect("handle-ioctl", lambda _, client: self.on_ioctl(client))
        host.bed.attach_ioctl(device.node, handler)
        host.keep.append(handler)
        self.fifo = host.make_fifo(device, os.O_NONBLOCK)
        self.refill()

    def refill(self) -> None:
        with contextlib.suppress(BlockingIOError):
            while True:
                os.write(self.fifo, b"\0" * 4096)

    def wake(self) -> None:
        with contextlib.suppress(BlockingIOError):
            os.read(self.fifo, 65536)

    def send(self, report: bytes) -> None:
        with self.lock:
            if self.waiting:
                self.finish(self.waiting.pop(0), report)
            else:
                self.queue.append(report)

    def vanish(self) -> None:
        with self.lock:
            for urb in self.waiting:
                self.finish(urb, None, -errno.ESHUTDOWN)
            self.waiting.clear()
            self.wake()

    def finish(self, urb: dict, payload: bytes | None, status: int = 0) -> None:
        n = urb["n"]
        if payload is not None and urb["buffer"] is not None:
            start = 8 if urb["type"] == 2 else 0
            payload = payload[: urb["length"] - start]
            urb["buffer"].update(start, payload)
            n = len(payload)
        urb["data"].update(4, struct.pack("<i", status))
        urb["data"].update(28, struct.pack("<i", n))
        self.done.append(urb)
        self.wake()

    def control(self, setup: bytes, out: bytes) -> bytes | None:
        kind, request, value, _, length = struct.unpack("<BBHHH", setup)
        if (kind, request, value >> 8) == (0x80, 6, 3):
            return self.strings.get(value & 255, b"\x02\x03")[:length]
        if (kind, request, value >> 8) == (0x81, 6, 0x22):
            return self.device.descriptor[:length]
        if (kind, request) == (0x21, 9):
            self.device.note(out)
            return None
        return b""

    def on_ioctl(self, client) -> bool:
        request, argument = client.get_request() & MASK, client.get_arg()
        with self.lock:
            if self.device.gone and request in (SUBMIT, CLAIM):
                client.complete(-1, errno.ENODEV)
            elif request == CAPABILITIES:
                argument.resolve(0, 4).update(0, struct.pack("<I", 0x05))
                client.complete(0, 0)
            elif request == SPEED:
                client.complete(2, 0)
            elif request in (CLAIM, RELEASE, CONFIGURE):
                client.complete(0, 0)
            elif request in (DRIVER, IOCTL):
                client.complete(-1, errno.ENODATA)
            elif request == SUBMIT:
                self.submit(client, argument)
            elif request in (REAP, REAP_NOW):
                self.reap(client, argument)
            elif request == DISCARD:
                for urb in list(self.waiting):
                    self.waiting.remove(urb)
                    self.finish(urb, None, -errno.ENOENT)
                client.complete(0, 0)
            else:
                client.complete(-1, errno.ENOTTY)
        return True

    def submit(self, client, argument) -> None:
        data = argument.resolve(0, 56)
        raw = bytes(data.retrieve())
        length = struct.unpack_from("<i", raw, 24)[0]
        buffer = data.resolve(16, length) if length else None
        urb = {"data": data, "buffer": buffer, "length": length, "type": raw[0], "n": 0}
        client.complete(0, 0)
        if raw[0] == 2:
            sent = bytes(buffer.retrieve())
            answer = self.control(sent[:8], sent[8:])
            urb["n"] = length - 8 if answer is None else 0
            self.finish(urb, answer)
        elif raw[1] & 0x80:
            if self.queue:
                self.finish(urb, self.queue.pop(0))
            else:
                self.waiting.append(urb)
        else:
            self.device.note(bytes(buffer.retrieve()))
            urb["n"] = length
            self.finish(urb, None)

    def reap(self, client, argument) -> None:
        if self.done:
            urb = self.done.pop(0)
            argument.resolve(0, 8).set_ptr(0, urb["data"])
            client.complete(0, 0)
            if not self.done and not self.device.gone:
                self.refill()
        elif self.device.gone:
            client.complete(-1, errno.ENODEV)
        else:
            self.refill()
            client.complete(-1, errno.EAGAIN)


def main() -> int:
    with open(sys.argv[1], encoding="utf-8") as file:
        scenario = json.load(file)
    devices = [Device(i, spec) for i, spec in enumerate(scenario["devices"])]
    host, players = Host(devices), []
    for device in devices:
        if not device.script or device.script[0][1] != "plug":
            host.plug(device)
        players.append(threading.Thread(target=host.play, args=(device,), daemon=True))
        players[-1].start()
    for folder, _, names in os.walk(os.path.join(host.root, "ioctl")):
        for name in [".", *names]:  # the program may give up its rights
            os.chmod(os.path.join(folder, name), 0o777)
    environment = dict(os.environ, LD_PRELOAD="libumockdev-preload.so.0", UMOCKDEV_DIR=host.root)
    program = subprocess.Popen(
        sys.argv[2:], env=environment,
        # a shell's background jobs, as tests may be, ignore what they are to obey here
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip

    def interrupt() -> None:
        for player in players:
            player.join()
        for device in devices:
            host.settle(device)
        program.send_signal(signal.SIGINT)

    if scenario["interrupt"]:
        threading.Thread(target=interrupt, daemon=True).start()
    code = program.wait()
    print("HOST " + json.dumps([device.written for device in devices]), flush=True)
    os._exit(code)  # the handlers' threads need not be waited for


if __name__ == "__main__":
    main()
