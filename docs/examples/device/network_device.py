#!/usr/bin/env python3
"""A device for Tandem's driver `network`: a handle that goes round in a circle and feels a force.

    tandem peer --session S --scene peg_in_slot --hold peg --device network &
    network_device.py 127.0.0.1:47111 [KEYFILE]

docs/devices.md has the packets. Nobody needs the other end's clock: each tells its own, and the echo of what it heard last.
"""
import hmac, math, os, select, socket, struct, sys, time

HEADER = struct.Struct("<4sBBHQQQqq")  # magic, version, kind, length, two sessions, sequence, time, echo
HELLO, STATE, WELCOME, FORCE, END = 1, 2, 129, 130, 131
host, port = sys.argv[1].rsplit(":", 1)
key = open(sys.argv[2], "rb").read().rstrip() if len(sys.argv) > 2 else None
link = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_DGRAM)
link.connect((host.strip("[]"), int(port)))
now, heard, due = time.monotonic_ns, 0, 0
motors, felt, based_on, expiry = (0.0,) * 6, None, 0, 0  # a device of your own gives `motors` to its motors

def code(text):
    return hmac.digest(key, text, "sha256") if key else b""

def send(kind, body):
    global sequence
    sequence += 1
    size = HEADER.size + len(body) + len(code(b""))
    text = HEADER.pack(b"TDMD", 1, kind, size, device, tandem, sequence, now(), echo) + body
    try:
        link.send(text + code(text))
    except ConnectionRefusedError:
        pass  # Tandem does not listen

while True:
    if now() - heard > 5 * 10**8:  # for half a second, or at the start: begin anew
        device, tandem, sequence, newest, echo = int.from_bytes(os.urandom(8), "little") | 1, 0, 0, 0, 0
        heard = now()
    if now() - based_on > 1000 * expiry:
        motors = (0.0,) * 6  # the state that this force follows from is too old: the force is void
    if now() >= due:
        a = 2 * math.pi * 1e-9 * now()
        if tandem:  # where the handle is, a thousand times a second
            send(STATE, struct.pack("<II13d", 3, 0, .05 * math.cos(a), .05 * math.sin(a), 0, 0, 0, 0, 1,
                                    -.1 * math.pi * math.sin(a), .1 * math.pi * math.cos(a), 0, 0, 0, 0))
        else:  # what the device can
            send(HELLO, struct.pack("<II15d32s", 6, 3, 1000, 5, *(0,) * 13, b"circle"))
        due = now() + (10**6 if tandem else 10**8)
    if not select.select([link], [], [], 1e-9 * max(0, due - now()))[0]:
        continue
    try:
        packet = link.recv(512)
    except ConnectionRefusedError:
        continue
    text = packet[:-32] if key else packet
    if len(text) < HEADER.size or not hmac.compare_digest(code(text), packet[len(text):]):
        continue
    magic, version, kind, size, ours, theirs, number, sent, answers = HEADER.unpack_from(text)
    if (magic, version, size, ours) != (b"TDMD", 1, len(packet), device):
        continue
    if kind == WELCOME and not tandem:
        tandem, echo, heard, due = theirs, sent, now(), 0
    elif theirs == tandem and number > newest:
        newest, echo, heard = number, sent, now()
        if kind == END:
            break
        if kind == FORCE and len(text) == 104:
            expiry, _, *motors = struct.unpack_from("<II6d", text, HEADER.size)
            based_on = answers
            if any(motors):
                felt = motors, 1e-6 * (now() - based_on)
motors = (0.0,) * 6
print("felt (N, N m): %s, %.2f ms after the state it follows from" % felt if felt else "felt nothing")
