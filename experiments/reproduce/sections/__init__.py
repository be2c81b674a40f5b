"""What each section of the report computes, says and draws; see `catalogue.SECTIONS`."""
