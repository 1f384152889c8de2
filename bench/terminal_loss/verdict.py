"""What must be seen on the cable when a terminal is lost, wherever in the job that is:
  - the valve's bit is off VALVE_MS after the loss and stays off
  - no axis is commanded to start again: once no drive has "enable operation", none gets it back
  - the last frame has no drive enabled (shutdown, disable voltage or quick stop), and its answer no axis that moves
  - within REST_S no position changes any more, and no frame of the controller comes after its end
  - the stations have left OP, no drive is in Operation Enabled, no position changes (asked on the cable afterwards)"""
import struct
import time

from wire import FPRD, BusError, Wire

VALVE_MS = 20.0  # from an order to the loop (docs/operating.md)
REST_S = 1.5     # braking from the machine's highest speed, and a drive's own stop in homing
ENABLE, OPERATION_ENABLED, OPERATION_MASK = 0x0F, 0x27, 0x6F  # IEC 61800-7-201, controlword and statusword
STILL_COUNTS = 2  # of a position between two frames: an encoder's last digit
QUICK_STOP, HOMING = 0x0002, 6
AL_STATUS, SM3_START, OP = 0x0130, 0x0818, 8
INPUTS_OF_AXIS = 19


def enabled(cycle):
    return any(a.control & ENABLE == ENABLE for a in cycle.axes)


def what_was_on(cycles):
    """In words, from the last few cycles."""
    said = [c for c in cycles[-40:] if not c.answer and c.axes]
    answered = [c for c in cycles[-40:] if c.answer and c.axes]
    if said and said[-1].valve:
        return "valve open"
    if said and any(a.mode == HOMING for a in said[-1].axes):
        return "homing"
    moves = len(answered) > 1 and any(abs(a.position - b.position) > STILL_COUNTS
                                      for a, b in zip(answered[0].axes, answered[-1].axes))
    return "moving" if moves else "standing"


def last_motion_ns(cycles):
    """When a position was seen to change for the last time."""
    at_ns, before = 0, None
    for c in cycles:
        if not c.answer or not c.axes:
            continue
        if before and any(abs(a.position - b.position) > STILL_COUNTS for a, b in zip(before.axes, c.axes)):
            at_ns = c.at_ns
        before = c
    return at_ns


def judge(cycles, loss, frames_not_heard):
    """What is wrong, and the figures of the case."""
    said = [c for c in cycles if not c.answer and c.axes and c.valve is not None]
    after = [c for c in said if c.at_ns > loss.at_ns]
    wrong = [f"{frames_not_heard} frames were not heard: nothing is shown"] if frames_not_heard else []
    if not after:
        return wrong + ["no frame after the loss: torque was not taken off in order"], ""
    was_open = any(c.valve for c in said if loss.at_ns - 2_000_000 < c.at_ns <= loss.at_ns)
    open_frames = sum(c.valve for c in after)
    last_open = max((i for i, c in enumerate(after) if c.valve), default=-1)
    valve_ms = max(0.0, (after[last_open].at_ns - loss.at_ns) / 1e6) if last_open >= 0 else 0.0
    if valve_ms > VALVE_MS:
        wrong.append(f"the valve's bit is on {valve_ms:.1f} ms after the loss")
    if open_frames != last_open + 1:
        wrong.append("the valve's bit comes on again")

    off = next((i for i, c in enumerate(after) if not enabled(c)), None)
    if off is None:
        wrong.append(f"the last frame leaves drives enabled: {[hex(a.control) for a in after[-1].axes]}")
    elif any(enabled(c) for c in after[off:]):
        wrong.append("drives are enabled again after all were told to stop")
    rest_ms = (last_motion_ns(cycles) - loss.at_ns) / 1e6
    if rest_ms > 1e3 * REST_S:
        wrong.append(f"axes still move {rest_ms:.0f} ms after the loss")
    stop = all(a.control == QUICK_STOP for a in after[-1].axes)
    figures = (f"{'valve %.1f ms, %d frames;' % (valve_ms, open_frames) if was_open else 'valve shut;':27} "
               f"moved {max(0.0, rest_ms):4.0f} ms, {'quick stop' if stop else 'in order':10} "
               f"after {(after[-1].at_ns - loss.at_ns) / 1e6:5.0f} ms:")
    return wrong, figures


def read_stations(interface, position_of, io_position):
    """What the stations themselves say when nobody drives them any more."""
    wire, wrong, positions = Wire(interface), [], []
    wire.keep = False
    try:
        for attempt in range(2):
            positions.append([])
            for station, position in sorted(position_of.items(), key=lambda item: item[1]):
                state = wire.ask(FPRD, station, AL_STATUS, 2).u() & 0x0F
                if state == OP:
                    wrong.append(f"station {position} was left in OP")
                if position == io_position:
                    continue
                start, length = struct.unpack("<HH", wire.ask(FPRD, station, SM3_START, 4).data)
                if start == 0 or length % INPUTS_OF_AXIS != 0:
                    continue  # back in INIT: its inputs are no longer set up
                inputs = wire.ask(FPRD, station, start, length)
                for at in range(0, length if inputs.wkc else 0, INPUTS_OF_AXIS):
                    status, _, here = struct.unpack_from("<Hbi", inputs.data, at)
                    positions[-1].append(here)
                    if status & OPERATION_MASK == OPERATION_ENABLED:
                        wrong.append(f"a drive at station {position} was left enabled")
            if attempt == 0:
                time.sleep(0.02)
    except BusError as e:
        wrong.append(f"the stations do not answer: {e}")
    finally:
        wire.socket.close()
    if len(positions) == 2 and any(abs(a - b) > STILL_COUNTS for a, b in zip(*positions)):
        wrong.append("an axis still moves at the end")
    return sorted(set(wrong))
