#!/bin/busybox sh
# The only program of the guest (built by tests/hil/deep/run): Linux with its own USB stack, udev, and omni and omnid of
# the build. Each line it prints is a check; at the end it stops the machine with a verdict.
/bin/busybox mkdir -p /proc /sys /dev /run /tmp /sbin
/bin/busybox --install -s /bin
export PATH=/bin XDG_RUNTIME_DIR=/run/root HOME=/tmp
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t devtmpfs dev /dev
stty -F /dev/ttyS1 raw
mkdir -m 700 /run/root

failed=0
line() {
  read -r up rest </proc/uptime
  printf '%-4s %6.2f s  %s\n' "$1" "$up" "$2"
}
passed() { line ok "$1"; }
failed() {
  line FAIL "$1"
  failed=$((failed + 1))
  shift
  [ $# -eq 0 ] || cat "$@"
}

# check WHAT COMMAND...: the command succeeds. Its output is in /tmp/out, and printed on failure.
check() {
  what=$1
  shift
  if "$@" >/tmp/out 2>&1; then passed "$what"; else failed "$what" /tmp/out; fi
}

# within WHAT COMMAND...: the command succeeds in time (a busy host is slow); otherwise the run ends.
patience_s=20
within() {
  end=$(($(date +%s) + patience_s))
  what=$1
  shift
  until "$@" >/tmp/out 2>&1; do
    if [ "$(date +%s)" -ge $end ]; then
      failed "$what" /tmp/out
      finish
    fi
    usleep 100000
  done
  passed "$what"
}

# The verdict is a byte to isa-debug-exit at port 0xf4: 16 means success.
verdict() {
  printf "$(printf '\\%03o' "$1")" | dd of=/dev/port bs=1 seek=244 2>/dev/null
}

# shows PATTERN COMMAND...: the command's output contains the pattern, whatever its status.
shows() {
  pattern=$1
  shift
  "$@" >/tmp/shown 2>&1
  cat /tmp/shown
  grep -q -- "$pattern" /tmp/shown
}

order() { echo "$1" >/dev/ttyS1; }

# The base's folder in sysfs.
base() {
  id=$(grep -l 1209 /sys/bus/usb/devices/*/idVendor 2>/dev/null) && dirname "$id"
}
is_there() { base; }
is_gone() { ! base; }
attribute() { shows "^$2\$" cat "$(base)/$1"; }
has_tag() { shows 'TAGS=.*:uaccess:' udevadm info --query=property --path="$(base)"; }
is_refused() { shows 70-omni.rules su -s /bin/sh nobody -c 'omni device info'; }
is_held() { shows 'another program holds.*omnid' omni device selftest --yes; }

# device KEY: its value in omnid's device status; empty: none.
device() { sed -n '/"device": {/,/^  }/s/^ *"'"$1"'": "\?\([^",]*\)"\?,\?$/\1/p' /tmp/status; }
look() { omni status --json >/tmp/status; }
has_received() { look && [ "$(device received)" -ge "$1" ]; }
has_none() { look && grep -q 'no Omni base on USB' /tmp/status; }
# Set-points that become too old in transit are not checked: they depend on how slow this computer is.
is_lossless() {
  look
  for count in bad_frames bad_crc interrupted missed; do
    echo "$count: $(device $count)"
    [ "$(device $count)" = 0 ] || return 1
  done
}
is_armed() { look && grep -q '"faults": \[\]' /tmp/status; }
is_stopped() { shows 'fault: emergency stop' omni status; }
ends_well() { kill -TERM "$omnid" && wait "$omnid"; }
is_content() { ! dmesg | grep -E 'usb|xhci' | grep -iE 'error|fail|warn|not responding|unable|cannot'; }

finish() {
  [ $failed -eq 0 ] || cat /tmp/status /tmp/omnid.log
  [ $failed -eq 0 ] || dmesg | grep -E 'usb|xhci'
  echo "guest: $failed failed, up $(cut -d ' ' -f 1 /proc/uptime) s"
  if [ $failed -eq 0 ]; then verdict 16; else verdict 1; fi
  poweroff -f
}

echo "guest: Linux $(uname -r), up $(cut -d ' ' -f 1 /proc/uptime) s"
for module in usb-common usbcore xhci-hcd xhci-pci; do insmod /modules/$module.ko; done
/lib/systemd/systemd-udevd --daemon 2>/dev/null
udevadm trigger
within 'the kernel enumerates the base' is_there
udevadm settle
check 'at high speed' attribute speed 480
check 'by the descriptors of the firmware' attribute version ' 2.10'
check 'with its configuration set' attribute bConfigurationValue 1
check 'the rule for udev gives it to the seat' has_tag
check 'omni device list' omni device list
cat /tmp/out
check 'another user is refused, and the error names the rule' is_refused
check 'omni device info' omni device info
check 'omni device selftest' omni device selftest --yes
cat /tmp/out
omnid --device usb >/tmp/omnid.log 2>&1 &
omnid=$!
within 'omnid receives scans' has_received 500
within 'the base is armed' is_armed
check 'the pen is tracked' grep '"status": "tracking"' /tmp/status
check 'no frame was lost or refused' is_lossless
check 'the base is held by omnid alone' is_held
order unplug
within 'the cable is pulled' is_gone
within 'omnid says so' has_none
order plug
within 'the cable is in again' is_there
within 'omnid has opened the base again' has_received 200
within 'the base is armed' is_armed
check 'no frame was lost or refused' is_lossless
check 'omni device estop' omni device estop
within 'the base has stopped' is_stopped
check 'omnid ends' ends_well
check 'the kernel reports no problem' is_content
finish
