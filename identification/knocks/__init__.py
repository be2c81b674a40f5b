"""Natural frequency and damping from the free vibration after knocks."""
