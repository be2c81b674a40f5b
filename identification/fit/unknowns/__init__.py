"""What a fit is free to change, and what is known of it otherwise."""
