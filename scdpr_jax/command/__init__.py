"""What moves the robot and what sees it: trajectories, shapers, controllers, sensors."""
