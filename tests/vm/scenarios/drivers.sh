# Both ends of each link together over the kernel's drivers: the test programs written beside the links.
. /bench/lib.sh
link=drivers
for program in usb_link_guest_test can_link_guest_test drive_socket_guest_test gpio_guest_test; do
  [ -x /bin/$program ] || { skip $program "not built"; continue; }
  $program >/out/$program.log 2>&1
  verdict $program "$(grep -m 1 -A 12 'FAILED' /out/$program.log | tr '\n' ' ' | cut -c1-300)"
  tail -n 3 /out/$program.log | sed -n 's/^\(All tests passed.*\|test cases.*\)/  \1/p'
done
