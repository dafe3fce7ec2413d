"""A table of paintings, one a row, painted on all cores; runs again where it was interrupted."""

import subprocess
import sys
from pathlib import Path

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out").resolve()
out.mkdir(exist_ok=True)

table = out / "orders.csv"
rows = ["text,object,output,size,resolution", "一,plane,one.ply,20,1.0", "二,plane,two.ply,20,1.0"]
table.write_text("\n".join(rows), "utf-8")
subprocess.run([sys.executable, "-m", "paint3d", "batch", str(table)], check=True, cwd=out)
print(*sorted(path.name for path in out.glob("*.ply")))
