/* The newest value (rt/base/latest_value.h): three buffers, one being written, one being read, one between; each side
 * exchanges its own with the one between in one atomic operation. Every interleaving is tried; a value has two halves.
 *
 * Holds: nobody reads half a value, a value does not change while it is looked at, values only get newer, and every one
 * is either taken, counted as superseded, or still between. Each variant must fail:
 *   WEAK_PUBLISH   the exchange comes before the second half: publish() without release, or take() without acquire
 *   WEAK_TAKE      a read of the old value after the exchange: take() without release, or publish() without acquire
 *   TORN           the exchange of publish() is a load and a store, not one operation
 */
#define VALUES 6
#define UNSEEN 4

byte one[3], two[3];
byte between = 1, superseded;
bool producer_done;

active proctype producer() {
  byte writing = 0, value = 1, before;
  do
  :: value > VALUES -> break
  :: else ->
    one[writing] = value;
#ifndef WEAK_PUBLISH
    two[writing] = value;
#endif
#ifdef TORN
    before = between;
    between = writing | UNSEEN;
#else
    atomic { before = between; between = writing | UNSEEN };
#endif
#ifdef WEAK_PUBLISH
    two[writing] = value;
#endif
    writing = before & 3;
    superseded = superseded + ((before & UNSEEN) / UNSEEN);
    value++
  od;
  producer_done = true
}

active proctype consumer() {
  byte reading = 2, newest = 0, taken = 0, before, old;
  bool over = false;
  do
  :: over -> break
  :: else ->
    over = producer_done;
    if
    :: (between & UNSEEN) != 0 ->
      old = reading;
      atomic { before = between; between = reading };
      reading = before & 3;
      taken++;
#ifdef WEAK_TAKE
      assert(newest == 0 || one[old] == newest);
#endif
      assert(one[reading] > newest);
      newest = one[reading];
      assert(two[reading] == newest)
    :: else -> assert(newest == 0 || (one[reading] == newest && two[reading] == newest))
    fi
  od;
  assert(taken + superseded == VALUES)
}
