"""The reference machine for campaigns that last: quicker on its way to its switches, and patient with its host."""
import os

TOP = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
REFERENCE = os.path.join(TOP, "config/machines/dispenser.yaml")
QUICKER = (("fast: 60 mm/s", "fast: 120 mm/s"), ("acceleration: 1000 mm/s^2", "acceleration: 4000 mm/s^2"))


def write(folder, patience):
    """Its file, in a folder that is made, with the profiles beside it. patience: pairs of what is written and what instead."""
    with open(REFERENCE) as file:
        text = file.read()
    for found, instead in (*patience, *QUICKER):
        assert found in text, found
        text = text.replace(found, instead)
    os.makedirs(os.path.join(folder, "machines"))
    for profiles in ("drives", "devices"):
        os.symlink(os.path.join(TOP, "config", profiles), os.path.join(folder, profiles))
    path = os.path.join(folder, "machines/quick.yaml")
    with open(path, "w") as file:
        file.write(text)
    return path
