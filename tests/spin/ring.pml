/* The ring (rt/base/ring.h): records of any length from one thread to another, dropped whole where they do not fit.
 * Every interleaving of the single loads and stores is tried, for records of one to three cells in a ring of four. A
 * cell is a record's header or a part of its payload; both hold the record's sequence number, so that one that was
 * overwritten, or is not there yet, shows.
 *
 * Holds: what comes out is whole, in order, and every record is either out or counted as lost just where it is missing;
 * each side's memory of the other's counter is never ahead of it; nobody waits. The orders are release on each counter's
 * store and acquire on its load; what the hardware might do without them is written as the program in that order, and
 * each such variant must fail:
 *   WEAK_COMMIT   head is there before the last cell: without release, or without acquire at the consumer
 *   WEAK_FREE     tail is there before the last cell was read: without release, or without acquire at the producer
 */
#define CELLS 4
#define RECORDS 7

byte cell[CELLS];         /* the sequence number + 1 of what was written there */
byte length_at[CELLS];    /* of a header */
byte head, tail;
byte dropped;
bool producer_done;

active proctype producer() {
  byte sequence = 0, seen_tail = 0, length, i;
  do
  :: sequence == RECORDS -> break
  :: else ->
    if
    :: length = 1
    :: length = 2
    :: length = 3
    fi;
    if
    :: CELLS - (head - seen_tail) < length -> seen_tail = tail  /* acquire */
    :: else
    fi;
    assert(seen_tail <= tail);
    if
    :: CELLS - (head - seen_tail) < length -> dropped++
    :: else ->
#ifdef WEAK_COMMIT
      head = head + length;
      d_step { cell[(head - length) % CELLS] = sequence + 1; length_at[(head - length) % CELLS] = length };
      i = 1;
      do
      :: i == length -> break
      :: else -> cell[(head - length + i) % CELLS] = sequence + 1; i++
      od
#else
      d_step { cell[head % CELLS] = sequence + 1; length_at[head % CELLS] = length };
      i = 1;
      do
      :: i == length -> break
      :: else -> cell[(head + i) % CELLS] = sequence + 1; i++
      od;
      head = head + length  /* release */
#endif
    fi;
    sequence++
  od;
  producer_done = true
}

active proctype consumer() {
  byte seen_head = 0, expected = 0, lost = 0, length, number, i;
  bool over = false;
  do
  :: over -> break
  :: else ->
    if
    :: seen_head == tail ->
      over = producer_done;  /* looked at first: what came before it is in head */
      seen_head = head       /* acquire */
    :: else
    fi;
    assert(seen_head <= head);
    if
    :: seen_head == tail -> skip  /* empty */
    :: else ->
      over = false;
      d_step { number = cell[tail % CELLS] - 1; length = length_at[tail % CELLS] };
      assert(number >= expected && number < RECORDS);
      lost = lost + number - expected;
      expected = number + 1;
#ifdef WEAK_FREE
      tail = tail + length;
      i = 1;
      do
      :: i >= length -> break
      :: else -> assert(cell[(tail - length + i) % CELLS] == number + 1); i++
      od
#else
      i = 1;
      do
      :: i >= length -> break
      :: else -> assert(cell[(tail + i) % CELLS] == number + 1); i++
      od;
      tail = tail + length  /* release */
#endif
    fi
  od;
  assert(lost + (RECORDS - expected) == dropped)
}
