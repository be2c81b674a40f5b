"""The joint loop: plant, gains in closed form, margins of stiff and flexible robots."""
