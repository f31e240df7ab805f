"""The smallest device for Tandem's driver `network`, without a key: smallest_device.py HOST:PORT (docs/devices.md has the packets)."""
import math, os, socket, struct, sys, time

HEADER = struct.Struct("<4sBBHQQQqq")  # magic, version, kind, length, two sessions, sequence, time, echo
link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
link.connect((sys.argv[1].split(":")[0], int(sys.argv[1].split(":")[1])))
link.setblocking(False)
device, tandem, sequence, echo, motors, most = int.from_bytes(os.urandom(8), "little") | 1, 0, 0, 0, (0.0,) * 6, 0.0
kind, void_ns = 0, 0  # of the newest packet; when the newest force is too old
while kind != 131:
    now, sequence = time.monotonic_ns(), sequence + 1
    x, v = 0.05 * math.sin(3e-9 * now), 0.15 * math.cos(3e-9 * now)  # to and fro along x
    body = struct.pack("<II15d32s", 6, 3, 1000, 5, *(0,) * 13, b"to and fro")  # a hello
    if tandem:  # a state
        body = struct.pack("<II13d", 3, 0, x, 0, 0, 0, 0, 0, 1, v, 0, 0, 0, 0, 0)
    try:
        link.send(HEADER.pack(b"TDMD", 1, 2 if tandem else 1, 48 + len(body), device, tandem, sequence, now, echo) + body)
        packet = link.recv(512)
        _, _, kind, _, ours, tandem, _, echo, answers = HEADER.unpack_from(packet)
        if kind == 130:
            expiry_us, _, *motors = struct.unpack_from("<II6d", packet, 48)
            void_ns = answers + 1000 * expiry_us
            most = max(most, math.dist(motors[:3], (0, 0, 0)))
    except BlockingIOError:
        pass
    except ConnectionRefusedError:
        kind = 131 if tandem else 0  # Tandem has ended, or has not begun
    motors = motors if time.monotonic_ns() < void_ns else (0.0,) * 6  # give these to your motors
    time.sleep(0.001 if tandem else 0.1)
print("felt at most %.2f N" % most)
