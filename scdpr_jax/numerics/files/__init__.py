"""Files: how a given one is read, how one is written whole, and what of it may be shown."""

from scdpr_jax.numerics.files.whole import settle as settle
from scdpr_jax.numerics.files.whole import whole_file as whole_file
from scdpr_jax.numerics.files.whole import write_bytes_whole as write_bytes_whole
from scdpr_jax.numerics.files.whole import write_whole as write_whole
