"""Learn squats of 2, 4, 6 and 8 cm and ask what to feed forward at 5 cm.

Everything runs in this process, no service needed: about two minutes. Give
smaller numbers for a quicker look: python ten_lines.py 0.02 0.04 0.03
(learned amplitudes, then the queried one, in metres).
"""

import sys
import tempfile

import tsd_casadi as tsd
from tsd_casadi import learn
from tsd_clients import MujocoSimulator

*learned, queried = map(float, sys.argv[1:]) if sys.argv[1:] else (0.02, 0.04, 0.06, 0.08, 0.05)

robot = tsd.load_robot("hermes_lower")  # or "my_robot.yaml"
controller = tsd.compile_controller(robot)  # compiled once, then cached
tick = controller.tick(robot.home, controller.command())
print(f"{tick.status.name}: knee torque {tick.tau[6]:.1f} N m in {tick.compute_time:.0f} us")

simulator = MujocoSimulator(robot, model_error=0.1)  # the controller is 10 % wrong
with tempfile.TemporaryDirectory() as folder, tsd.Database(f"{folder}/squat.sqlite") as database:
    learn(simulator, controller, [tsd.Squat(a, 0.25) for a in learned], database)
    feedforward = database.query("squat", amplitude=queried, frequency=0.25)

for name, chosen in (("without", None), (feedforward.kind, feedforward)):
    run = simulator.run(controller, tsd.Squat(queried, 0.25), feedforward=chosen)
    print(f"{name:12s} RMS error {1e3 * run.errors['com.z'].rms:8.4f} mm")
