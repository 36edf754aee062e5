"""What the QP minimises beside the tasks: posture [P_null, qdd_des] and contact forces."""
