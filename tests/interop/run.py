"""python3 run.py MASTER INTERFACE MACHINE CAPTURE: one of the strange masters (soem, igh, twincat, refusals) against the
segment behind INTERFACE. Exit 75: it failed, but the host stood still for longer than a station bears, so that the
failure says nothing about the segment."""
import importlib
import sys
import traceback

from expected import expected_stations
from wire import BusError, Wire

STALL_S = 0.02


def main():
    name, interface, machine, capture = sys.argv[1:5]
    master = importlib.import_module(name)
    bus = Wire(interface, master.SOURCE)
    try:
        master.main(bus, expected_stations(machine))
        return 0
    except BusError:
        traceback.print_exc()
        stall = max(bus.worst_gap, bus.worst_turn)
        print(f"longest stall {1e3 * stall:.1f} ms", flush=True)
        return 75 if stall > STALL_S else 1
    finally:
        bus.write_pcapng(capture)


sys.exit(main())
