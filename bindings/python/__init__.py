"""Found by versions of Python for which the module, which lies beside, is not built."""
import sys
from pathlib import Path

_modules = ", ".join(sorted(file.name for file in Path(__file__).parent.glob("__init__.*.so")))
raise ImportError(f"altiro3d: is not built for {sys.executable} (Python {sys.version.split()[0]}), expected "
                  f"the Python of {_modules or 'a build of altiro3D'}; -DPython3_EXECUTABLE={sys.executable} "
                  "builds it for this one")
