#!/bin/sh
# plugged_in_test.sh TREPHINE: emulated devices of umockdev are found by their names. Skipped without umockdev.
command -v umockdev-run >/dev/null || exit 77
found=$(umockdev-run -d "$(dirname "$0")/plugged_in.umockdev" -- "$1" doctor --devices)
echo "$found"
echo "$found" | grep -q "Novint Falcon as 'falcon:0', /dev/bus/usb/001/007" || { echo "no Falcon"; exit 1; }
echo "$found" | grep -q "SpaceMouse Compact as 'spacemouse:0', /dev/hidraw0" || { echo "no SpaceMouse"; exit 1; }
echo "$found" | grep -q "Force Dimension device as 'omega:0', /dev/bus/usb/001/008" || { echo "no omega"; exit 1; }
echo "$found" | grep -q "3D Systems Touch as 'touch', /dev/bus/usb/001/009" || { echo "no Touch"; exit 1; }
echo "$found" | grep -q "the library of OpenHaptics is" || { echo "the library of OpenHaptics was not checked"; exit 1; }
# Without emulated devices, no device is found.
"$1" doctor --devices | grep -q "'falcon:0'\|'omega:0'\|'spacemouse:0'\|as 'touch'" && { echo "found a device that is not there"; exit 1; }
exit 0
