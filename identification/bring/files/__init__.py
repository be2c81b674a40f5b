"""From a file of any make to its channels: what each file's reader gives, and where it runs."""
