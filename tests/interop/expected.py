"""What the machine file and its profiles say stands on the bus; read as text, so that no code of the project has a part
in the judgement.

    for e in expected_stations("config/machines/dispenser.yaml"): e.vendor, e.objects, e.axes
"""
import pathlib
import re


class Expected:
    def __init__(self, name, text):
        self.name, self.text = name, text
        ident = re.search(r"identity: \{vendor: (\w+), product: (\w+), revision: (\w+)", text)
        self.vendor, self.product, self.revision = (int(v, 0) for v in ident.groups())
        self.objects = [(int(i, 16), int(s or 0)) for i, s in
                        re.findall(r"^  - \{object: 0x([0-9A-Fa-f]{4})(?::(\d+))?, *name:", text, re.M)]
        self.axes = int(re.search(r"^slots: (\d)", text, re.M).group(1))
        self.ethercat = "bus: ethercat" in text
        self.mailbox = "mailbox_out" in text
        self.map_entries = int(m.group(1)) if (m := re.search(r"^max_pdo_entries: (\d+)", text, re.M)) else None


def expected_stations(machine):
    """Expected stations of the EtherCAT line in the order of their positions."""
    machine = pathlib.Path(machine)
    rows = []
    for name, profile, position in re.findall(r"^  (\w+):\s+\{profile: (\w+), *position: (\d+)", machine.read_text(), re.M):
        for folder in ("drives", "devices"):
            path = machine.parent.parent / folder / f"{profile}.yaml"
            if path.exists():
                rows.append((int(position), Expected(name, path.read_text())))
    return [e for _, e in sorted(((p, e) for p, e in rows if e.ethercat), key=lambda row: row[0])]
