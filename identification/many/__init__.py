"""Many fits: of short runs in one batch, of campaigns one after the other."""
