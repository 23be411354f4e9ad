/* The exchange between the two worlds (rt/haptics/exchange.h, rt/base/double_buffer.h): G(n) one way, H(n) the other,
 * two buffers each. Every interleaving of the single loads and stores is tried; a value has two halves, so that one that
 * changes while it is read, or is not there yet, shows.
 *
 * Holds: nobody reads half a value, nor another cycle's; nobody waits for ever; the haptic side can always go on with
 * the snapshot that it has. The orders are release and acquire on the number of a direction: a release keeps what is
 * before it before it, an acquire what is after it after it. What the hardware might do without them is written as the
 * program in that order; each such variant must fail:
 *   WEAK_PUBLISH   the number is there before the second half: publish() without release, or try_read() without acquire
 *   WEAK_RETURN    a read of G(n-1) after the publish of H(n): without release on the way back
 *   NO_TURN        the global side does not wait for H(n) before it writes G(n+1)
 */
#define CYCLES 6

byte g_one[2], g_two[2], h_one[2], h_two[2];
byte g_published, h_published;

inline write_g(n) {
  g_one[(n) & 1] = n;
#ifdef WEAK_PUBLISH
  g_published = (n) + 1;
  g_two[(n) & 1] = n;
#else
  g_two[(n) & 1] = n;
  g_published = (n) + 1;
#endif
}

inline read_g(n) {
  assert(g_one[(n) & 1] == n);
  assert(g_two[(n) & 1] == n);
}

active proctype haptic() {
  byte n = 0;
  do
  :: n == CYCLES -> break
  :: n < CYCLES ->
    if  /* one look a tick: adopt what is there, or go on with the one before */
    :: g_published > n ->
#ifdef WEAK_RETURN
      h_one[n & 1] = n;
      h_two[n & 1] = n;
      h_published = n + 1;
      if
      :: n > 0 -> read_g(n - 1)
      :: else
      fi;
      read_g(n);
#else
      read_g(n);
      h_one[n & 1] = n;
      h_two[n & 1] = n;
      h_published = n + 1;
#endif
      n++
    :: else ->
      if
      :: n > 0 -> read_g(n - 1)
      :: else
      fi
    fi
  od;
  read_g(CYCLES - 1)
}

active proctype global() {
  byte n = 0;
  write_g(0);
  do
  :: n == CYCLES - 1 -> break
  :: else ->
#ifndef NO_TURN
    h_published > n;  /* acquire */
    assert(h_one[n & 1] == n);
    assert(h_two[n & 1] == n);
#endif
    n++;
    write_g(n)
  od
}
