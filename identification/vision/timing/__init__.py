"""When each row of each picture was exposed, and what follows from that."""
