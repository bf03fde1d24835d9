# shellcheck shell=dash
# What jobs in the guest use: `. /guest.sh`. Every function says what it could not do and ends the job.

fail() { echo "guest: $*" >&2; exit 1; }

# load_vivid: an independent camera at /dev/video10, a webcam with test patterns and errors to inject through its controls.
load_vivid() {
  modprobe vivid n_devs=1 vid_cap_nr=10 node_types=0x1 num_inputs=1 input_types=0 || fail "no vivid"
}

# load_loopback [COUNT]: v4l2loopback devices from /dev/video0 on, written by one program and read by another.
load_loopback() {
  modprobe v4l2loopback devices="${1:-1}" video_nr="$(seq -s, 0 $((${1:-1} - 1)))" exclusive_caps=1 max_buffers=8 ||
    fail "no v4l2loopback"
}

# make_lines NAME...: a chip of simulated lines with these names, from offset 0 on. Sets GPIO_CHIP (its device, /dev/gpiochipN) and
# GPIO_LINES (folder with sim_gpioOFFSET/value, what an output drives, and sim_gpioOFFSET/pull, which an input sees).
make_lines() {
  modprobe gpio-sim || fail "no gpio-sim"
  local folder=/sys/kernel/config/gpio-sim/relnav offset=0 name device chip
  mkdir "$folder" "$folder/bank0" || fail "cannot make $folder"
  echo $# >"$folder/bank0/num_lines"
  echo relnav >"$folder/bank0/label"
  for name; do
    mkdir "$folder/bank0/line$offset"
    echo "$name" >"$folder/bank0/line$offset/name"
    offset=$((offset + 1))
  done
  echo 1 >"$folder/live" || fail "gpio-sim does not come to life"
  device=$(cat "$folder/dev_name") chip=$(cat "$folder/bank0/chip_name")
  GPIO_CHIP=/dev/$chip
  GPIO_LINES=/sys/devices/platform/$device/$chip
  { [ -c "$GPIO_CHIP" ] && [ -d "$GPIO_LINES" ]; } || fail "no $GPIO_CHIP or no $GPIO_LINES"
}

# record_rises OFFSET: sets RISES to a pipe that gives one line each time when a program drives this line of make_lines high. None
# is lost, however short: the kernel's trace of the line, where sim_gpioOFFSET/value would have to be polled.
record_rises() {
  local chip base='' instance=/sys/kernel/tracing/instances/line$1
  [ -d /sys/kernel/tracing/instances ] || mount -t tracefs tracefs /sys/kernel/tracing || fail "no tracefs"
  for chip in /sys/class/gpio/gpiochip*; do
    [ "$(cat "$chip/label")" != relnav ] || base=$(cat "$chip/base")
  done
  [ -n "$base" ] || fail "make_lines comes first"
  mkdir "$instance" || fail "cannot make $instance"
  echo "gpio == $((base + $1)) && get == 0 && value == 1" >"$instance/events/gpio/gpio_value/filter"
  echo 0 >"$instance/buffer_percent"
  echo 1 >"$instance/events/gpio/gpio_value/enable" || fail "the kernel does not trace its lines"
  # shellcheck disable=SC2034  # for the job
  RISES=$instance/trace_pipe
}
