"""What holds a robot in a period for which no torque was answered."""
