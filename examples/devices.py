"""What is plugged in, in which kind, and whether it may be opened."""

from paint3d.device.hid_nodes import list_nodes
from paint3d.errors import DeviceError

try:
    nodes = list_nodes()
except DeviceError as failure:
    nodes = []
    print(failure)
for node in nodes:
    print(f"{node.kind:6} {node.vendor:04x}:{node.product:04x} {node.path}")
print(f"{len(nodes)} devices; `paint3d devices watch` shows what they say")
