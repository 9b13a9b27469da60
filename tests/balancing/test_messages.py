# ruff: noqa: E501
"""Every message about a measured rotor's file, word for word: where, what, why, and the way out."""

from __future__ import annotations

import pytest

from rotor_jobs import FAN, messages
from vibopt.errors import InputError
from vibopt.jobs import from_text

CASES: dict[str, tuple[list[tuple[str, str]], list[str]]] = {
    "no conventions": (
        [
            (
                '[conventions]\nphase = "lag"\nreadings = "phase"\nangles = "against rotation"\ndetector = "pp"\nzero = "reflective tape"\n',
                "",
            )
        ],
        [
            'fan.toml: the table [conventions] is missing. Write phase = "lag", readings = "phase", angles = "against rotation", detector = "pp" and zero = "reflective tape" as they are on your instrument; vibopt does not guess them.'
        ],
    ),
    "no phase": (
        [('phase = "lag"\n', "")],
        [
            'fan.toml line 2: conventions has no phase: whether the angle of a reading says how far the vibration lags or leads the reference. Write phase = "lag" or phase = "lead".'
        ],
    ),
    "bad phase": (
        [('phase = "lag"\n', 'phase = "late"\n')],
        [
            'fan.toml line 3: conventions.phase = "late" is no word for whether the angle of a reading says how far the vibration lags or leads the reference. Write phase = "lag" or phase = "lead".'
        ],
    ),
    "no zero": (
        [('zero = "reflective tape"\n', "")],
        ['fan.toml line 2: conventions has no zero: where angle zero is, in words. Write zero = "reflective tape".'],
    ),
    "zero number": (
        [('zero = "reflective tape"\n', "zero = 3\n")],
        [
            'fan.toml line 7: conventions.zero = 3 is no text: where angle zero is, in words. Write zero = "reflective tape".'
        ],
    ),
    "two runs of one name": (
        [('name = "trial right"\n', 'name = "trial left"\n')],
        [
            'fan.toml line 22: runs[3].name = "trial left" is the name of run 2 at the same speed already: messages and reports could not tell the two apart. Write another name, or remove one of the runs if it is a copy.'
        ],
    ),
    "conv unknown": (
        [('detector = "pp"\n', 'detector = "pp"\nsens="cw"\n')],
        ['fan.toml line 7: unknown key "sens" in conventions. Known: phase, readings, angles, detector, zero.'],
    ),
    "no initial": (
        [
            (
                'name = "as found"\nspeed = "1200 rpm"\nreadings = { a = "8.6 mil @ 63 deg", b = "6.5 mil @ 206 deg" }\n[[runs]]\n',
                "",
            )
        ],
        [
            "fan.toml line 12: there is no initial run: every run has weights fitted. Add a run as found, with its speed and readings and without weights."
        ],
    ),
    "no runs": (
        [
            (
                '[[runs]]\nname = "as found"\nspeed = "1200 rpm"\nreadings = { a = "8.6 mil @ 63 deg", b = "6.5 mil @ 206 deg" }\n[[runs]]\nname = "trial left"\nspeed = "1200 rpm"\nweights = { left = "10 g @ 270 deg" }\nreadings = { a = "5.9 mil @ 123 deg", b = "4.5 mil @ 228 deg" }\n[[runs]]\nname = "trial right"\nspeed = "1200 rpm"\nweights = { right = "12 g @ 180 deg" }\nreadings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n',
                "",
            )
        ],
        ["fan.toml: there is no initial run. Add [[runs]] with speed and readings as found, and without weights."],
    ),
    "zero initial vibration": (
        [
            (
                'readings = { a = "8.6 mil @ 63 deg", b = "6.5 mil @ 206 deg" }\n',
                'readings = { a = "0 mil @ 63 deg", b = "0 mil @ 0 deg" }\n',
            )
        ],
        [
            "fan.toml line 12: the initial vibration is zero at every sensor: there is nothing to balance. Check the readings as found."
        ],
    ),
    "zero trial": (
        [('weights = { left = "10 g @ 270 deg" }\n', 'weights = { left = "0 g @ 270 deg" }\n')],
        [
            'fan.toml line 19: runs[2].weights.left = "0 g @ 270 deg" is a trial weight of zero: it says nothing about its plane. Leave the plane out of this run.'
        ],
    ),
    "a plane that is not there": (
        [('weights = { left = "10 g @ 270 deg" }\n', 'weights = { lefd = "10 g @ 270 deg" }\n')],
        ['fan.toml line 19: run "trial left" has a weight in plane lefd, which is not there. Did you mean "left"?'],
    ),
    "fewer runs than planes": (
        [
            (
                '[[runs]]\nname = "trial right"\nspeed = "1200 rpm"\nweights = { right = "12 g @ 180 deg" }\nreadings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n',
                "",
            )
        ],
        [
            "fan.toml line 12: fewer runs than planes: to learn what a weight does in left and right, 2 runs with weights are needed at 1200 rpm, and there is 1 run with weights. Add a run with a weight in right, write keep = true in [planes.right], or give ready coefficients in [[influence]]."
        ],
    ),
    "a plane never tried": (
        [('weights = { right = "12 g @ 180 deg" }\n', 'weights = { left = "12 g @ 180 deg" }\n')],
        [
            "fan.toml line 12: no run at 1200 rpm has a weight in plane right, so nothing is known of it. Add such a run, or write keep = true in [planes.right]."
        ],
    ),
    "identical trial runs": (
        [
            ('weights = { left = "10 g @ 270 deg" }\n', 'weights = { left = "20 g @ 270 deg", right="2 g @ 3 deg" }\n'),
            (
                'weights = { right = "12 g @ 180 deg" }\n',
                'weights = { left = "10 g @ 270 deg", right="1 g @ 3 deg" }\n',
            ),
        ],
        [
            'fan.toml line 12: runs "trial left" and "trial right" have the same weights (up to a common factor), so planes left and right cannot be told apart: the equations are singular at 1200 rpm. Move one of the weights to another plane and repeat that run.'
        ],
    ),
    "a reading without phase": (
        [
            (
                'readings = { a = "5.9 mil @ 123 deg", b = "4.5 mil @ 228 deg" }\n',
                'readings = { a = "5.9 mil", b = "4.5 mil @ 228 deg" }\n',
            )
        ],
        [
            'fan.toml line 20: runs[2].readings.a = "5.9 mil" has no angle, but other readings have one. Write "8.6 mil pp @ 63 deg"; balancing without phase needs every reading without an angle.'
        ],
    ),
    "mixed detectors": (
        [
            (
                'readings = { a = "5.9 mil @ 123 deg", b = "4.5 mil @ 228 deg" }\n',
                'readings = { a = "5.9 mil rms @ 123 deg", b = "4.5 mil @ 228 deg" }\n',
            )
        ],
        [
            'fan.toml line 20: runs[2].readings.a = "5.9 mil rms @ 123 deg" is rms, but sensor a otherwise reads pp. Mixed detectors are seldom meant: write every reading of a with the same one.'
        ],
    ),
    "mixed dim": (
        [
            (
                'readings = { a = "5.9 mil @ 123 deg", b = "4.5 mil @ 228 deg" }\n',
                'readings = { a = "5.9 mm/s @ 123 deg", b = "4.5 mil @ 228 deg" }\n',
            )
        ],
        [
            'fan.toml line 20: runs[2].readings.a = "5.9 mm/s @ 123 deg" is a velocity, but sensor a otherwise reads a displacement. Read one kind.'
        ],
    ),
    "a missing sensor": (
        [
            (
                'readings = { a = "5.9 mil @ 123 deg", b = "4.5 mil @ 228 deg" }\n',
                'readings = { a = "5.9 mil @ 123 deg" }\n',
            )
        ],
        [
            'fan.toml line 20: run "trial left" has no reading of sensor b, which other runs or [sensors] have. Add it, or leave b out of every run.'
        ],
    ),
    "negative": (
        [
            (
                'readings = { a = "5.9 mil @ 123 deg", b = "4.5 mil @ 228 deg" }\n',
                'readings = { a = "-5.9 mil @ 123 deg", b = "4.5 mil @ 228 deg" }\n',
            )
        ],
        [
            'fan.toml line 20: runs[2].readings.a = "-5.9 mil @ 123 deg" is a negative amplitude. Write it positive and turn the angle by 180 deg.'
        ],
    ),
    "negw": (
        [('weights = { left = "10 g @ 270 deg" }\n', 'weights = { left = "-10 g @ 270 deg" }\n')],
        [
            'fan.toml line 19: runs[2].weights.left = "-10 g @ 270 deg" is a negative amplitude. Write it positive and turn the angle by 180 deg.'
        ],
    ),
    "an angle above 360": (
        [
            (
                'readings = { a = "5.9 mil @ 123 deg", b = "4.5 mil @ 228 deg" }\n',
                'readings = { a = "5.9 mil @ 423 deg", b = "4.5 mil @ 228 deg" }\n',
            )
        ],
        [
            'fan.toml line 20: runs[2].readings.a = "5.9 mil @ 423 deg" has an angle above 360 deg. Write "63 deg", or correct it.'
        ],
    ),
    "360w": (
        [('weights = { left = "10 g @ 270 deg" }\n', 'weights = { left = "10 g @ 370 deg" }\n')],
        [
            'fan.toml line 19: runs[2].weights.left = "10 g @ 370 deg" has an angle above 360 deg. Write "10 deg", or correct it.'
        ],
    ),
    "speed mismatch": (
        [('name = "trial right"\nspeed = "1200 rpm"\n', 'name = "trial right"\nspeed = "1300 rpm"\n')],
        [
            'fan.toml line 23: run "trial right" is at 1300 rpm, but as found was measured at 1200 rpm. A weight acts differently at each speed: repeat the run at 1200 rpm, or add a run as found at 1300 rpm.'
        ],
    ),
    "no speed": (
        [('name = "trial right"\nspeed = "1200 rpm"\n', 'name = "trial right"\n')],
        [
            'fan.toml line 21: run "trial right" has no speed. Write speed = "1200 rpm" in each run, or once at the top level.'
        ],
    ),
    "holes without weights": (
        [('[planes.left]\nradius = "150 mm"\n', '[planes.left]\nradius = "150 mm"\nholes = 24\n')],
        [
            'fan.toml line 10: planes.left has holes without weights. Add shelf = ["5 g", "10 g"] with the weights there are, or split = true for a weight cut to measure in the two neighbouring holes.'
        ],
    ),
    "shelf": (
        [('[planes.left]\nradius = "150 mm"\n', '[planes.left]\nradius = "150 mm"\nshelf = ["5 g"]\n')],
        [
            "fan.toml line 10: planes.left has weights on the shelf, but no holes to put them. Add holes = 24, or a list of angles."
        ],
    ),
    "a cap of zero": (
        [
            (
                '[planes.left]\nradius = "150 mm"\n',
                '[planes.left]\nradius = "150 mm"\nweight = { from = "0 g", to = "0 g" }\n',
            )
        ],
        [
            'fan.toml line 10: planes.left.weight = { from = "0 g", to = "0 g" } is a cap of zero: nothing could be put here. Write keep = true to leave the plane untouched, or a cap.'
        ],
    ),
    "fact": (
        [('[planes.left]\nradius = "150 mm"\n', '[planes.left]\nradius = "150 mm"\nweight = "60 g"\n')],
        [
            'fan.toml line 10: planes.left.weight = "60 g" is no range. The correction is to be chosen: write { from = "0 g", to = "60 g" }; or write the weight that is fitted with its angle, "10 g @ 270 deg".'
        ],
    ),
    "from": (
        [
            (
                '[planes.left]\nradius = "150 mm"\n',
                '[planes.left]\nradius = "150 mm"\nweight = { from = "2 g", to = "60 g" }\n',
            )
        ],
        [
            'fan.toml line 10: planes.left.weight = { from = "2 g", to = "60 g" } does not start at zero. No weight at all is always possible: write from zero.'
        ],
    ),
    "lim0": (
        [
            (
                'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n',
                'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n[limits.x]\nresponse = "correction"\nof = "left"\nat_most = "0 g"\n',
            )
        ],
        [
            'fan.toml line 29: limits.x.at_most = "0 g" is a cap of zero: nothing could be put there. Write keep = true in the plane, or a cap.'
        ],
    ),
    "lim kind": (
        [
            (
                'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n',
                'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n[limits.x]\nresponse = "residual"\nat = "c"\nat_most = "1 mil"\n[limits.y]\nresponse = "force"\nat_most="1 N"\n[limits.z]\nresponse = "residual"\nat_most = "1 mm/s"\n',
            )
        ],
        [
            'fan.toml line 28: limits.x.at = "c" names no sensor of this job. Known: a, b.',
            'fan.toml line 31: limits.y.response = "force" is no response of a measured rotor. Known: residual, correction.',
            'fan.toml line 35: limits.z.at_most = "1 mm/s" does not fit sensor a, which reads in mil. Write a limit in such a unit, or name the sensor with at.',
        ],
    ),
    "lim speed": (
        [
            (
                'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n',
                'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n[limits.x]\nresponse = "residual"\nspeed = "900 rpm"\nat_most = "1 mil"\n',
            )
        ],
        ['fan.toml line 28: limits.x.speed = "900 rpm" is a speed at which nothing was measured. Measured: 1200 rpm.'],
    ),
    "goal": (
        [
            (
                'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n',
                'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n[goal]\nminimise = "residuum"\n',
            )
        ],
        ['fan.toml line 27: goal.minimise = "residuum" is no response of a measured rotor. Did you mean "residual"?'],
    ),
    "goal2": (
        [
            (
                'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n',
                'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n[goal]\nminimise = "correction"\n',
            )
        ],
        [
            'fan.toml line 26: the least correction without a limit on the residual is none at all. Add [limits.NAME] with response = "residual".'
        ],
    ),
    "goal3": (
        [
            (
                'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n',
                'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n[goal]\nminimise = "residual"\ncombine="huber"\n',
            )
        ],
        [
            'fan.toml line 26: goal has combine = "huber" without huber_at. Write huber_at = "1 mil pp", from where amplitudes count linearly.'
        ],
    ),
    "goal4": (
        [
            (
                'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n',
                'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n[goal]\nminimise = "residual"\nrobust="worst"\n',
            )
        ],
        [
            'fan.toml line 28: goal.robust needs the scatter of the readings. Add scatter = { amplitude = "5 %", angle = "2 deg" }.'
        ],
    ),
    "allkeep": (
        [
            ('[planes.left]\nradius = "150 mm"\n', '[planes.left]\nradius = "150 mm"\nkeep = true\n'),
            ('[planes.right]\nradius = "150 mm"\n', '[planes.right]\nradius = "150 mm"\nkeep = true\n'),
        ],
        ["fan.toml line 8: every plane has keep = true: nothing may be changed. Leave one plane free."],
    ),
    "unk sensor": (
        [('[planes.right]\nradius = "150 mm"\n', '[planes.right]\nradius = "150 mm"\n[sensors.a]\n[sensors.c]\n')],
        [
            'fan.toml line 17: run "as found" has a reading of sensor b, which is not there. Known: a, c.',
            'fan.toml line 17: run "as found" has no reading of sensor c, which other runs or [sensors] have. Add it, or leave c out of every run.',
            'fan.toml line 22: run "trial left" has a reading of sensor b, which is not there. Known: a, c.',
            'fan.toml line 22: run "trial left" has no reading of sensor c, which other runs or [sensors] have. Add it, or leave c out of every run.',
            'fan.toml line 27: run "trial right" has a reading of sensor b, which is not there. Known: a, c.',
            'fan.toml line 27: run "trial right" has no reading of sensor c, which other runs or [sensors] have. Add it, or leave c out of every run.',
        ],
    ),
    "no weight angle": (
        [('weights = { left = "10 g @ 270 deg" }\n', 'weights = { left = "10 g" }\n')],
        ['fan.toml line 19: runs[2].weights.left = "10 g" has no angle. Write "10 g @ 270 deg".'],
    ),
    "no angle unit": (
        [('weights = { left = "10 g @ 270 deg" }\n', 'weights = { left = "10 g @ 270" }\n')],
        [
            'fan.toml line 19: runs[2].weights.left = "10 g @ 270" has the angle "270", which has no unit. Write "270 deg".'
        ],
    ),
    "stayed": (
        [('name = "as found"\n', 'name = "as found"\nstayed = true\n')],
        ["fan.toml line 14: the first run has stayed = true, but no run is before it. Remove stayed."],
    ),
    "key": (
        [('name = "as found"\n', 'nmae = "as found"\n')],
        ['fan.toml line 13: unknown key "nmae" in runs[1]. Did you mean "name"?'],
    ),
    "probability": (
        [
            (
                '[[runs]]\nname = "as found"',
                '[limits.a]\nresponse = "correction"\nof = "left"\nat_most = "9 g"\nwith_probability = "95 %"\n[[runs]]\nname = "as found"',
            )
        ],
        [
            'fan.toml line 16: unknown key "with_probability" in limits.a. Limits of machines, and on what is left in a measured rotor, have one. Of known masses and engines: vibopt sweep FILE --keep-design.'
        ],
    ),
    "source": (
        [('title = "Two-plane fan"\n', 'title = "Two-plane fan"\nsource = 3\n')],
        ["fan.toml line 2: source = 3 is not a text. Write it in quotation marks."],
    ),
    "radius of a coefficient": (
        [
            ('[planes.left]\nradius = "150 mm"\n', '[planes.left]\nradius=["100 mm","150 mm"]\n'),
            ('weights = { left = "10 g @ 270 deg" }\n', 'weights = { left = "10 g at 100 mm @ 270 deg" }\n'),
            ("[planes.left]", '[[influence]]\nsensor = "a"\nplane = "left"\nvalue = "1 mil/g @ 20 deg"\n[planes.left]'),
        ],
        [
            'fan.toml line 11: influence[1].value = "1 mil/g @ 20 deg" does not say at which radius of planes.left the g sits. Write "1 mil/(g at 100 mm) @ 20 deg".'
        ],
    ),
    "top": (
        [('title = "Two-plane fan"\n', 'titel = "Two-plane fan"\n')],
        ['fan.toml line 1: unknown key "titel" at the top level. Did you mean "title"?'],
    ),
    "hole": (
        [
            ('[planes.left]\nradius = "150 mm"\n', '[planes.left]\nradius = "150 mm"\nholes = 24\nshelf=["5 g"]\n'),
            ('weights = { left = "10 g @ 270 deg" }\n', 'weights = { left = "10 g in hole 25" }\n'),
        ],
        [
            'fan.toml line 21: runs[2].weights.left = "10 g in hole 25" names a hole that is not there: planes.left has holes 1 to 24.'
        ],
    ),
    "radii": (
        [('[planes.left]\nradius = "150 mm"\n', '[planes.left]\nradius=["100 mm","150 mm"]\n')],
        [
            'fan.toml line 19: runs[2].weights.left = "10 g @ 270 deg" does not say at which radius of planes.left. Write "10 g at 100 mm @ 270 deg".'
        ],
    ),
    "forb": (
        [
            (
                '[planes.left]\nradius = "150 mm"\n',
                '[planes.left]\nradius = "150 mm"\nholes = 4\nshelf=["5 g"]\nforbidden=["350..340 deg"]\n',
            )
        ],
        [
            "fan.toml line 12: planes.left: every hole lies in a forbidden sector. Narrow the sectors, or write keep = true."
        ],
    ),
    "drill": (
        [
            (
                '[planes.left]\nradius = "150 mm"\n',
                '[planes.left]\nradius = "150 mm"\ndrill = { diameter="10 mm", density="7850 kg"}\n',
            )
        ],
        [
            "fan.toml line 10: planes.left has a drill, but adds weights. Write remove = true, or leave the drill out.",
            'fan.toml line 10: planes.left.drill.density = "7850 kg" is a mass, but a density is needed here. Write a density, for example "7850 kg/m³".',
        ],
    ),
    "infl": (
        [
            (
                '[[runs]]\nname = "trial right"\nspeed = "1200 rpm"\nweights = { right = "12 g @ 180 deg" }\nreadings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n',
                '[[influence]]\nsensor="a"\nplane="right"\nvalue="0.3 mil/g @ 3 deg"\n',
            )
        ],
        [
            'fan.toml line 21: plane right has no influence coefficient for sensor b at 1200 rpm. Add [[influence]] with sensor = "b", plane = "right".'
        ],
    ),
    "infl2": (
        [
            (
                '[[runs]]\nname = "trial right"\nspeed = "1200 rpm"\nweights = { right = "12 g @ 180 deg" }\nreadings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n',
                '[[influence]]\nsensor="a"\nplane="right"\nvalue="0.3 mil"\n',
            )
        ],
        [
            'fan.toml line 24: influence[1].value = "0.3 mil" is no influence coefficient. Write what a unit weight at 0 deg would read, "0.43 mil pp/g @ 120 deg".'
        ],
    ),
    "nophase": (
        [
            (
                'readings = { a = "8.6 mil @ 63 deg", b = "6.5 mil @ 206 deg" }\n',
                'readings = { a = "8.6 mil", b = "6.5 mil" }\n',
            ),
            (
                'readings = { a = "5.9 mil @ 123 deg", b = "4.5 mil @ 228 deg" }\n',
                'readings = { a = "5.9 mil", b = "4.5 mil" }\n',
            ),
            (
                'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n',
                'readings = { a = "6.2 mil", b = "10.4 mil" }\n',
            ),
        ],
        [
            'fan.toml line 12: the readings have no angles, and plane left has 1 trial position of its own at 1200 rpm. Write the readings with their angles, "8.6 mil pp @ 63 deg", or fit a weight in left alone at three angles (two leave two answers).',
            'fan.toml line 12: the readings have no angles, and plane right has 1 trial position of its own at 1200 rpm. Write the readings with their angles, "8.6 mil pp @ 63 deg", or fit a weight in right alone at three angles (two leave two answers).',
        ],
    ),
    "csv": (
        [
            ('title = "Two-plane fan"\n', 'readings = "nope.csv"\ntitle = "Two-plane fan"\n'),
            (
                '[[runs]]\nname = "as found"\nspeed = "1200 rpm"\nreadings = { a = "8.6 mil @ 63 deg", b = "6.5 mil @ 206 deg" }\n[[runs]]\nname = "trial left"\nspeed = "1200 rpm"\nweights = { left = "10 g @ 270 deg" }\nreadings = { a = "5.9 mil @ 123 deg", b = "4.5 mil @ 228 deg" }\n[[runs]]\nname = "trial right"\nspeed = "1200 rpm"\nweights = { right = "12 g @ 180 deg" }\nreadings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n',
                "",
            ),
        ],
        ["fan.toml line 1: nope.csv is not there. Name the CSV file, relative to the problem file."],
    ),
    "csv2": (
        [
            ('title = "Two-plane fan"\n', 'readings = "nope.csv"\ntitle = "Two-plane fan"\n'),
            (
                '[[runs]]\nname = "as found"\nspeed = "1200 rpm"\nreadings = { a = "8.6 mil @ 63 deg", b = "6.5 mil @ 206 deg" }\n[[runs]]\nname = "trial left"\nspeed = "1200 rpm"\nweights = { left = "10 g @ 270 deg" }\nreadings = { a = "5.9 mil @ 123 deg", b = "4.5 mil @ 228 deg" }\n[[runs]]\nname = "trial right"\nspeed = "1200 rpm"\nweights = { right = "12 g @ 180 deg" }\nreadings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n',
                "[sensors.a]\n",
            ),
        ],
        ["fan.toml line 1: nope.csv is not there. Name the CSV file, relative to the problem file."],
    ),
    "dims": (
        [
            (
                'readings = { a = "8.6 mil @ 63 deg", b = "6.5 mil @ 206 deg" }\n',
                'readings = { a = "8.6 mil @ 63 deg", b = "6.5 mm/s @ 206 deg" }\n',
            ),
            (
                'readings = { a = "5.9 mil @ 123 deg", b = "4.5 mil @ 228 deg" }\n',
                'readings = { a = "5.9 mil @ 123 deg", b = "4.5 mm/s @ 228 deg" }\n',
            ),
            (
                'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n',
                'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mm/s @ 162 deg" }\n',
            ),
        ],
        [
            "fan.toml: sensors a and b read in mil and mm/s, which cannot be added. Give every sensor its importance (a factor on its amplitude in SI units)."
        ],
    ),
}


@pytest.mark.parametrize(("edits", "said"), CASES.values(), ids=CASES)
def test_the_message_is_said_word_for_word(edits: list[tuple[str, str]], said: list[str]) -> None:
    text = FAN
    for old, new in edits:
        assert old in text
        text = text.replace(old, new, 1)
    assert messages(text) == said


def test_the_file_itself_is_right() -> None:
    assert messages(FAN) == []


LAST = 'readings = { a = "6.2 mil @ 36 deg", b = "10.4 mil @ 162 deg" }\n'
QUALITY = '[quality]\ngrade = "6.3 mm/s"\nmass = "80 kg"\ncentre_of_mass = "450 mm"\nbearings = { A = "0 mm", B = "900 mm" }\n'
LEFT = '[planes.left]\nradius = "150 mm"\n'
CONTRADICTIONS: dict[str, tuple[str, str, list[str]]] = {
    "mark with phase": (
        'readings = "phase"\n',
        'readings = "mark"\n',
        [
            'fan.toml line 3: conventions.phase = "lag" is for phase angles, but readings = "mark" says that the readings are positions of the mark. Leave phase out, or write readings = "phase".'
        ],
    ),
    "a pair of one plane": (
        LAST,
        LAST + '[pairs.p]\nplanes = ["left", "left"]\nkind = "couple"\n',
        [
            'fan.toml line 27: pairs.p.planes = ["left", "left"] is one plane with itself. Write two planes, for example planes = ["left", "right"].'
        ],
    ),
    "a pair with one radius": (
        'left]\nradius = "150 mm"\n[planes.right]\nradius = "150 mm"\n',
        'left]\nradius = "150 mm"\n[planes.right]\n[pairs.p]\nplanes = ["left", "right"]\nkind = "static"\n',
        ["fan.toml line 11: pairs.p sets unbalances equal, but planes.right has no radius. Add its radius."],
    ),
    "forbidden all round": (
        LEFT,
        LEFT + 'forbidden = ["0..360 deg"]\n',
        [
            "fan.toml line 10: planes.left has forbidden sectors all the way round: no weight could sit anywhere. Narrow them, or write keep = true."
        ],
    ),
    "forbidden all round where holes are": (
        LEFT,
        LEFT + 'holes = 12\nshelf = ["5 g"]\nforbidden = ["0..360 deg"]\n',
        [
            "fan.toml line 12: planes.left has forbidden sectors all the way round: no weight could sit anywhere. Narrow them, or write keep = true."
        ],
    ),
    "cut in two without holes": (
        LEFT,
        LEFT + "split = true\n",
        [
            "fan.toml line 10: planes.left.split needs holes and no shelf: the weight is cut to measure. Remove split, or the shelf."
        ],
    ),
    "no sensor counts": (
        LAST,
        LAST + "[sensors.a]\nimportance = 0\n[sensors.b]\nimportance = 0\n",
        [
            'fan.toml line 26: every sensor has importance = 0, so nothing is left to make small. Give one of them an importance greater than zero, or write minimise = "correction" under limits on the residual.'
        ],
    ),
    "a negative importance": (
        LAST,
        LAST + '[sensors.a]\nunit = "mil"\nimportance = -1\n[sensors.b]\n',
        ['fan.toml line 28: sensors.a.importance = -1 is negative. Write a positive value, for example "20 %".'],
    ),
    "two coefficients for one place": (
        LAST,
        LAST + '[[influence]]\nsensor = "a"\nplane = "right"\nvalue = "0.3 mil/g @ 3 deg"\n'
        '[[influence]]\nsensor = "b"\nplane = "right"\nvalue = "0.3 mil/g @ 3 deg"\n'
        '[[influence]]\nsensor = "a"\nplane = "right"\nspeed = "1201 rpm"\nvalue = "0.9 mil/g @ 3 deg"\n',
        [
            'fan.toml line 34: influence[3] says "0.9 mil/g @ 3 deg" for sensor a and a weight in right, influence[1] "0.3 mil/g @ 3 deg" at the same speed. Keep the one that holds.'
        ],
    ),
    "forbidden all round in pieces": (
        LEFT,
        LEFT + 'forbidden = ["350..100 deg", "90..200 deg", "200..355 deg"]\n',
        [
            "fan.toml line 10: planes.left has forbidden sectors all the way round: no weight could sit anywhere. Narrow them, or write keep = true."
        ],
    ),
    "a hole twice": (
        LEFT,
        LEFT + 'holes = ["0 deg", "30 deg", "360 deg"]\nshelf = ["5 g"]\n',
        ["fan.toml line 10: planes.left.holes lists 0 deg again, a full turn on. List each hole once."],
    ),
    "kept and removed": (
        LEFT,
        LEFT + "keep = true\nremove = true\n",
        [
            "fan.toml line 11: planes.left has keep = true and remove = true. Leave one out: nothing is removed from a plane that is kept."
        ],
    ),
    "quality of a plane that is not there": (
        LAST,
        LAST + QUALITY + 'planes = { left = "150 mm", rght = "750 mm" }\n',
        ['fan.toml line 31: quality.planes names no plane "rght" of this job. Did you mean "right"?'],
    ),
    "quality without one plane": (
        LAST,
        LAST + QUALITY + 'planes = { left = "150 mm" }\n',
        ['fan.toml line 31: quality.planes has no place for plane right. Add right = "750 mm", or leave planes out.'],
    ),
    "quality with two planes at one place": (
        LAST,
        LAST + QUALITY + 'planes = { left = "150 mm", right = "15 cm" }\n',
        [
            "fan.toml line 31: quality.planes has left and right at the same place, 150 mm: such planes cannot hold a couple. Write the place of each along the shaft."
        ],
    ),
    "stayed in words": (
        'name = "trial right"\n',
        'name = "trial right"\nstayed = "WAHR"\n',
        [
            'fan.toml line 23: runs[3].stayed = "WAHR" is neither true nor false. Write one of them, without quotation marks.'
        ],
    ),
}


@pytest.mark.parametrize(("old", "new", "said"), CONTRADICTIONS.values(), ids=CONTRADICTIONS)
def test_what_cannot_be_meant_is_refused(old: str, new: str, said: list[str]) -> None:
    assert FAN.count(old) == 1
    assert messages(FAN.replace(old, new)) == said


def test_a_coefficient_may_stand_twice_in_two_units() -> None:
    ready = '[[influence]]\nsensor = "{}"\nplane = "right"\nvalue = "{} @ 3 deg"\n'
    listed = [("a", "0.3 mil/g"), ("b", "0.2 mil/g"), ("a", "0.0076200 mm/g")]
    assert messages(FAN + "".join(ready.format(*one) for one in listed)) == []


@pytest.mark.parametrize("sectors", ['["0..170 deg", "180..360 deg"]', '["10..0 deg"]', '["200..100 deg"]'])
def test_sectors_that_leave_a_gap_are_taken(sectors: str) -> None:
    assert messages(FAN.replace(LEFT, f"{LEFT}forbidden = {sectors}\n")) == []


@pytest.mark.parametrize("kind", ["[masses.a]\n", "[engine]\n", "[quality]\n"])
def test_a_title_and_records_are_read_alike_of_every_kind_of_job(kind: str) -> None:
    with pytest.raises(InputError) as refused:
        from_text(f"title = 3\nexpected = 3\n{kind}", "a.toml")
    assert "a.toml line 1: title = 3 is not a text. Write it in quotation marks." in refused.value.messages
    records = "a.toml line 2: expected is not a list of tables. Write [[expected]] above each record."
    assert records in refused.value.messages
