"""What is kept on disk between processes: machine code, compiled programs, traced steps."""
