"""Record what TSID answers to the task stacks of test_tsid.py.

Run, in an environment of its own, which cannot be the project's:

    pip install pin==3.4.0 tsid==1.7.1 "cmeel-urdfdom<5" "cmeel-tinyxml2<11"
    python tests/recorded/record_tsid.py

Two soles or four points on the ground, the centre of mass and the trunk's orientation as
tasks: they determine all accelerations, so that nothing is left to what the two
formulations do with the rest. Contact forces are drawn to a wanted wrench by the same weights.
"""

import json
import re
from pathlib import Path

import numpy as np
import pinocchio
import tsid.tsid_pywrap as tsid

ROBOTS = Path(__file__).parents[1] / "robots"
EACH = 24
BIPED = ("near_pad", "far_pad")
QUADRUPED = ("fl_paw", "fr_paw", "rl_paw", "rr_paw")
SOLE = np.array([[x, y, 0.0] for x in (-0.07, 0.07) for y in (-0.035, 0.035)]).T
UP = np.array([0.0, 0.0, 1.0])
# far above the 1e-8 that its solver adds to all variables, forces at corners among them
WEIGHTS = {"com": 10.0, "trunk": 1.0, "force": 1e-3, "moment": 1e-2, "joints": 1e-7}
# of the contacts' rows, where they are in the cost
HELD = 1e5
CASES = {
    "mini_biped": ("mini_biped", BIPED, (), 10.0),
    "five_joints": ("mini_biped", BIPED, ("near_cant", "far_cant"), 10.0),
    "mini_quadruped": ("mini_quadruped", QUADRUPED, (), 0.4),
    "two_joints": (
        "mini_quadruped",
        QUADRUPED,
        tuple(f"{leg}_swing" for leg in ("fl", "fr", "rl", "rr")),
        0.4,
    ),
}
HOME = {
    "mini_biped": {"pitch": 0.05, "slide": 0.16, "ankle": -0.05},
    "mini_quadruped": {"lift": 0.7, "bend": -1.4},
}


def load(folder, locked):
    """Load a URDF with some joints fixed."""
    text = (ROBOTS / folder / f"{folder}.urdf").read_text()
    for joint in locked:
        text = re.sub(rf'name="{joint}" type="\w+"', f'name="{joint}" type="fixed"', text)
    path = Path("/tmp") / f"tsid_{folder}_{len(locked)}.urdf"
    path.write_text(text)
    folders = pinocchio.StdVec_StdString()
    return tsid.RobotWrapper(str(path), folders, pinocchio.JointModelFreeFlyer(), False)


def draw(model, folder, feet, rng, alike):
    """Draw a posture with the feet on the ground, at rest."""
    q = pinocchio.neutral(model)
    turns = {kind: rng.normal(scale=0.03) for kind in ("pitch", "slide", "lift", "bend")}
    for joint in model.names[2:]:
        kind = joint.split("_")[-1]
        angle = HOME[folder].get(kind, 0.0) + turns.get(kind, 0.0)
        if not alike:
            angle += rng.normal(scale=0.05)
        q[model.joints[model.getJointId(joint)].idx_q] = angle
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, q)
    q[2] = -np.mean([data.oMf[model.getFrameId(foot)].translation[2] for foot in feet])
    return q


def solve(robot, folder, feet, mu, q, com, turn, limit, held=None):
    """Solve one tick; None where the solver refuses.

    With a weight for ``held`` the contacts' rows are in the cost: where they depend on each
    other eiquadprog refuses them as equalities.
    """
    v = np.zeros(robot.nv)
    formulation = tsid.InverseDynamicsFormulationAccForce("tsid", robot, False)
    formulation.computeProblemData(0.0, q, v)
    data = formulation.data()
    weight = 9.81 * sum(inertia.mass for inertia in robot.model().inertias)
    kept = []
    for foot in feet:
        if folder == "mini_biped":
            contact = tsid.Contact6d(foot, robot, foot, SOLE, UP, mu, 2.0, 1e4)
            size, spread = 6, np.sqrt([1, 1, 1] + 3 * [WEIGHTS["moment"] / WEIGHTS["force"]])
        else:
            contact = tsid.ContactPoint(foot, robot, foot, UP, mu, 2.0, 1e4)
            contact.useLocalFrame(False)
            size, spread = 3, np.ones(3)
        contact.setKp(np.zeros(size))
        contact.setKd(np.zeros(size))
        placement = robot.framePosition(data, robot.model().getFrameId(foot))
        contact.setReference(placement)
        contact.setRegularizationTaskWeightVector(spread)
        wanted = np.zeros(size)
        wanted[2] = weight / len(feet)
        contact.setForceReference(wanted)
        formulation.addRigidContact(
            contact, WEIGHTS["force"], held or 1.0, 0 if held is None else 1
        )
        kept.append(contact)
    mass = tsid.TaskComEquality("com", robot)
    mass.setKp(np.zeros(3))
    mass.setKd(np.zeros(3))
    sample = tsid.TrajectorySample(3)
    sample.value(robot.com(data))
    sample.second_derivative(com)
    mass.setReference(sample)
    trunk = tsid.TaskSE3Equality("trunk", robot, "trunk")
    trunk.setKp(np.zeros(6))
    trunk.setKd(np.zeros(6))
    trunk.useLocalFrame(False)
    trunk.setMask(np.array([0.0, 0, 0, 1, 1, 1]))
    placed = tsid.TrajectorySample(12, 6)
    pose = robot.framePosition(data, robot.model().getFrameId("trunk"))
    placed.value(np.concatenate((pose.translation, pose.rotation.reshape(-1, order="F"))))
    placed.second_derivative(np.concatenate((np.zeros(3), turn)))
    trunk.setReference(placed)
    joints = tsid.TaskJointPosture("joints", robot)
    joints.setKp(np.zeros(robot.na))
    joints.setKd(np.zeros(robot.na))
    still = tsid.TrajectorySample(robot.na)
    still.value(q[7:])
    joints.setReference(still)
    formulation.addMotionTask(mass, WEIGHTS["com"], 1, 0.0)
    formulation.addMotionTask(trunk, WEIGHTS["trunk"], 1, 0.0)
    formulation.addMotionTask(joints, WEIGHTS["joints"], 1, 0.0)
    bounds = tsid.TaskActuationBounds("torques", robot)
    bounds.setBounds(-limit * np.ones(robot.na), limit * np.ones(robot.na))
    formulation.addActuationTask(bounds, 1.0, 0, 0.0)
    solver = tsid.SolverHQuadProgFast("solver")
    problem = formulation.computeProblemData(0.0, q, v)
    solver.resize(formulation.nVar, formulation.nEq, formulation.nIn)
    solution = solver.solve(problem)
    if solution.status != 0:
        return int(solution.status), None
    forces = []
    for contact in kept:
        force = formulation.getContactForce(contact.name, solution)
        forces.append((contact.getForceGeneratorMatrix @ force).tolist())
    return 0, {
        "qdd": formulation.getAccelerations(solution).tolist(),
        "forces": forces,
        "tau": formulation.getActuatorForces(solution).tolist(),
    }


def main():
    """Solve all cases and write them down."""
    recorded = {"weights": WEIGHTS, "cases": {}}
    for case, (folder, feet, locked, mu) in CASES.items():
        robot, rng, ticks = load(folder, locked), np.random.default_rng(0), []
        for index in range(EACH):
            q = draw(robot.model(), folder, feet, rng, alike=index % 2 == 0)
            com, turn = rng.normal(scale=0.5, size=3), rng.normal(scale=0.5, size=3)
            limit = 500.0
            given = (robot, folder, feet, mu, q, com, turn)
            status, answer = solve(*given, limit)
            if answer is None:
                _, answer = solve(*given, limit, HELD)
            if answer is not None and index % 3 == 0:
                # the same again with torques that are not enough
                limit = 0.9 * float(np.abs(answer["tau"]).max())
                _, answer = solve(*given, limit, None if status == 0 else HELD)
            ticks.append(
                {
                    "alike": index % 2 == 0,
                    "q": q.tolist(),
                    "com": com.tolist(),
                    "turn": turn.tolist(),
                    "limit": limit,
                    "status": status,
                    "answer": answer,
                }
            )
        print(case, [tick["status"] for tick in ticks])
        recorded["cases"][case] = {
            "joints": list(robot.model().names[2:]),
            "friction": mu,
            "ticks": ticks,
        }
    path = Path(__file__).parent / "tsid.json"
    path.write_text(json.dumps(recorded, indent=None))


if __name__ == "__main__":
    main()
