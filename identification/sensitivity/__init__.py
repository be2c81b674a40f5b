"""What measurements can tell of which quantities, by rank and scaled sensitivities."""
