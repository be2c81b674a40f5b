"""What logged legs tell of the robot that legs are planned for."""
