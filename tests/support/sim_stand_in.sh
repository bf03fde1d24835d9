#!/bin/sh
# Stands in for `relnav sim --scenario FILE --run K --result FILE` where a campaign is tested, not what it flies. The result
# follows from scenario and run; the scenario's lines say what else happens: `burn N` (work), `sleep S`, and `WHAT RUN...` with
# crash, hang, lost, half (a result cut short), silent (none), status3, unusable.
set -u
[ "$1 $2 $4 $6" = "sim --scenario --run --result" ] || { echo "relnav: unknown arguments $*" >&2; exit 2; }
scenario=$3 run=$5 result=$7
name=stand-in burn=0 outcome=tracked problem= what=
while read -r key values; do
  case $key in
    name:) name=$values ;;
    burn) burn=$values ;;
    sleep) sleep "$values" ;;
    crash|hang|lost|half|silent|status3|unusable) case " $values " in *" $run "*) what=$key ;; esac ;;
  esac
done <"$scenario"
crc=${scenario%.yaml}.crc
if [ -f "$crc" ]; then read -r crc <"$crc"; else crc=0badcafe; fi  # of what the scenario names
case $what in
  crash) kill -SEGV $$ ;;
  hang) while :; do sleep 1; done ;;
  silent) exit 0 ;;
  status3) exit 3 ;;
  unusable) echo "relnav: $scenario:7: the inertia is negative (expected a positive one)" >&2; exit 2 ;;
  lost) outcome=lost problem="lost at 12.$run s" ;;
esac
x=$((run + 1)) k=0
draw() { x=$(((x * 1103515245 + 12345) % 2147483648)); drawn=$((x / 2147484)); }  # 0 to 999
while [ $k -lt "$burn" ]; do draw; k=$((k + 1)); done
x=$((run * 7919 + 1)); draw; draw
draw; a=$drawn; draw; b=$drawn; draw; c=$drawn
text="{\"scenario\": \"$name\", \"scenario_crc\": \"$crc\", \"version\": \"0.1.0\", \"run\": $run, \"seed\": 987654321$run,
 \"outcome\": \"$outcome\", \"problem\": \"$problem\", \"frames\": 300, \"poses\": $((300 - a / 100)), \"invalid_flagged_valid\": 0,
 \"figures\": {\"attitude_max_deg\": 0.$(printf %03d "$a"), \"position_rms_m\": $((b / 10)).5e-3, \"nothing\": null},
 \"nees\": {\"sum\": $((1600 + c / 5)).25, \"count\": 298, \"dof\": 6}, \"dispersed\": {\"motion.rate.1\": 2.$(printf %03d "$c")}"
if [ "$what" = half ]; then
  printf '%s' "$text" >"$result"
  exit 0
fi
printf '%s, "wall_s": 0.%d}\n' "$text" $$ >"$result.new"
mv "$result.new" "$result"
[ "$outcome" = tracked ]
