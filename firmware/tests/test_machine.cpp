// The verifier is tested with valid code, and with code that differs in one byte for each reason of refusal.
// The machine is tested, too.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <vector>

#include "check.h"
#include "machine.h"

namespace {

using namespace machine;
using Bytes = std::vector<uint8_t>;

// The slots of these laws: x, v, a state 2, a constant 3, temporaries 4 to 6.
constexpr uint8_t kState = 2, kConstant = 3, kTemporary = 4, kSlots = 7;

uint32_t cycles = 0;

Refusal verified(const Bytes& bytes, float constant = 5.0f, uint8_t states = 1, uint8_t given = 2,
                 uint8_t slots = kSlots) {
  const Shape shape{states, given, slots, static_cast<uint16_t>(bytes.size())};
  if (!fits(shape)) return Refusal::kTooLarge;
  std::memset(arena, 0, kArena);
  machine::slots()[kState] = 1.0f;
  machine::slots()[kConstant] = constant;
  std::copy(bytes.begin(), bytes.end(), code(shape));
  return verify(shape, &cycles);
}

// Return a valid law that consists of one section.
Bytes law(std::initializer_list<uint8_t> body) {
  Bytes bytes{kMain};
  bytes.insert(bytes.end(), body);
  bytes.push_back(kReturn);
  return bytes;
}

Refusal verified_law(std::initializer_list<uint8_t> body) { return verified(law(body)); }

uint16_t most(uint8_t opcode) { return kTable[opcode < kMasked ? opcode : kSingle + (opcode - kMasked) / kMasks].most; }

}  // namespace

TEST(a_valid_law_passes_and_runs) {
  CHECK(verified_law({kLoad, 0, kMultiply, kConstant, kNegate}) == Refusal::kNone);
  CHECK(cycles == uint32_t(most(kLoad) + most(kMultiply) + most(kNegate) + most(kReturn)));
  CHECK(run(0.5f, 0.0f) == -2.5f);
}

TEST(a_law_larger_than_the_arena_is_too_large) {
  const uint16_t room = kArena - 4 * kSlots - kRamps * kRamp;
  Bytes bytes(room, kNegate);
  bytes.front() = kMain;
  bytes.back() = kReturn;
  CHECK(verified(bytes) == Refusal::kNone);
  bytes.insert(bytes.begin() + 1, kNegate);
  CHECK(verified(bytes) == Refusal::kTooLarge);
}

TEST(an_inconsistent_shape_is_too_large) {
  CHECK(verified(law({}), 5.0f, 1, 1, 3) == Refusal::kNone);
  CHECK(verified(law({}), 5.0f, 2, 1, 4) == Refusal::kTooLarge);  // there are more states than given values
  CHECK(verified(law({}), 5.0f, 1, 2, 3) == Refusal::kTooLarge);  // there are more given values than slots
}

TEST(operations_must_be_known_complete_and_inside_a_section) {
  for (int opcode = 0; opcode < 256; opcode++) {
    const bool known = opcode < kMasked ? opcode < kSingle && kTable[opcode].operands != kUnknown : opcode < 0x60;
    const Refusal found = verified_law({static_cast<uint8_t>(opcode), kTemporary, 0, 0});
    CHECK(known || found == Refusal::kOperation);
  }
  CHECK(verified({kMain, kReturn}) == Refusal::kNone);
  // there is an operation before the first section
  CHECK(verified({kNegate, kMain, kReturn}) == Refusal::kOperation);
  CHECK(verified({kMain, kReturn, kAdd}) == Refusal::kOperation);              // the instruction is truncated
  CHECK(verified({kMain, kReturn, kLoadAt, 0, 0}) == Refusal::kOperation);
  CHECK(verified({kMain, kReturn, kMain, kReturn}) == Refusal::kOperation);    // there are two MAIN sections
  CHECK(verified({kMain, kReturn, kSubroutine, kReturn}) == Refusal::kOperation);
}

TEST(operands_must_be_slots_of_the_law) {
  for (uint8_t opcode : {kLoad, kAdd, kMultiply, kPower, kCopysign}) {
    CHECK(verified_law({opcode, kSlots - 1}) == Refusal::kNone);
    CHECK(verified_law({opcode, kSlots}) == Refusal::kSlot);
    CHECK(verified_law({opcode, 255}) == Refusal::kSlot);
  }
  CHECK(verified_law({kCompare | 1, kSlots - 1, 0}) == Refusal::kNone);
  CHECK(verified_law({kCompare | 1, kSlots, 0}) == Refusal::kSlot);
}

TEST(only_states_and_temporaries_are_writable) {
  for (uint8_t slot = 0; slot <= kSlots; slot++) {
    const bool writable = slot == kState || (slot >= kTemporary && slot < kSlots);
    CHECK(verified_law({kStore, slot}) == (writable ? Refusal::kNone : Refusal::kSlot));
    CHECK(verified_law({kStoreAt, 0, slot, 1}) == (writable ? Refusal::kNone : Refusal::kSlot));
  }
}

TEST(tables_must_be_inside_the_slots) {
  CHECK(verified_law({kLoadAt, 0, 0, kSlots}) == Refusal::kNone);
  CHECK(verified_law({kLoadAt, 0, 1, kSlots}) == Refusal::kSlot);
  CHECK(verified_law({kLoadAt, 0, 0, 0}) == Refusal::kSlot);
  CHECK(verified_law({kLoadAt, 0, kSlots - 1, 255}) == Refusal::kSlot);
  CHECK(verified_law({kLoadAt, kSlots, 0, 1}) == Refusal::kSlot);
  CHECK(verified_law({kStoreAt, 0, kTemporary, 3}) == Refusal::kNone);
  CHECK(verified_law({kStoreAt, 0, kTemporary, 4}) == Refusal::kSlot);
  CHECK(verified_law({kStoreAt, 0, kState, 1}) == Refusal::kNone);
  CHECK(verified_law({kStoreAt, 0, kState, 2}) == Refusal::kSlot);       // this writes a constant
  CHECK(verified_law({kStoreAt, 0, kState, 4}) == Refusal::kSlot);       // this writes across a constant
  // there are no constants between the writable slots
  CHECK(verified(law({kStoreAt, 0, kState, 4}), 5.0f, 2, 2) == Refusal::kNone);
}

TEST(jumps_must_lead_forward_to_an_instruction_of_the_same_section) {
  CHECK(verified_law({kJump, 0}) == Refusal::kNone);
  CHECK(verified_law({kJump, 1, kNegate}) == Refusal::kNone);
  CHECK(verified_law({kJump, 2, kNegate}) == Refusal::kJump);           // jumps beyond the end
  CHECK(verified_law({kJump, 1, kAdd, 0}) == Refusal::kJump);           // jumps into an instruction
  CHECK(verified_law({kTest | 1, 2, kAdd, 0}) == Refusal::kNone);
  CHECK(verified_law({kTest | 1, 3, kAdd, 0}) == Refusal::kJump);
  CHECK(verified_law({kCompare | 1, 0, 2, kAdd, 0}) == Refusal::kNone);
  CHECK(verified_law({kCompare | 1, 0, 1, kAdd, 0}) == Refusal::kJump);
  CHECK(verified_law({kFarJump, 1, 0, kNegate}) == Refusal::kNone);
  CHECK(verified_law({kFarJump, 0xff, 0xff, kNegate}) == Refusal::kJump);
  CHECK(verified({kSubroutine, kTest | 1, 0, kReturn, kMain, kReturn}) == Refusal::kNone);
  // jumps up to MAIN
  CHECK(verified({kSubroutine, kTest | 1, 1, kReturn, kMain, kReturn}) == Refusal::kJump);
  // jumps beyond MAIN
  CHECK(verified({kSubroutine, kTest | 1, 2, kReturn, kMain, kReturn}) == Refusal::kJump);
}

TEST(the_number_of_pending_jumps_is_limited) {
  for (uint8_t count : {kMostJumps, uint16_t(kMostJumps + 1)}) {
    Bytes bytes{kMain};
    for (uint8_t i = 0; i < count; i++) {
      // as many pending jumps as allowed, each with a different target, then one more
      bytes.push_back(kTest | 1);
      bytes.push_back(static_cast<uint8_t>(2 * (count - 1 - i) + i));
    }
    bytes.insert(bytes.end(), count, kNegate);
    bytes.push_back(kReturn);
    CHECK(verified(bytes) == (count == kMostJumps ? Refusal::kNone : Refusal::kJump));
  }
}

TEST(loops_may_only_be_entered_at_their_start) {
  CHECK(verified_law({kLoop, 0, 3, 0, kNegate, kNext, 0, 5, 0}) == Refusal::kNone);
  CHECK(verified_law({kTest | 1, 0, kLoop, 0, 3, 0, kNegate, kNext, 0, 5, 0}) == Refusal::kNone);
  // a jump into a loop
  CHECK(verified_law({kTest | 1, 4, kLoop, 0, 3, 0, kNegate, kNext, 0, 5, 0}) == Refusal::kJump);
  CHECK(verified_law({kTest | 1, 5, kLoop, 0, 3, 0, kNegate, kNext, 0, 5, 0}) == Refusal::kJump);
  // a jump past a loop
  CHECK(verified_law({kTest | 1, 9, kLoop, 0, 3, 0, kNegate, kNext, 0, 5, 0}) == Refusal::kNone);
  // a jump out of a loop
  CHECK(verified_law({kLoop, 0, 3, 0, kTest | 1, 4, kNext, 0, 6, 0}) == Refusal::kNone);
  // a jump to the end of a loop
  CHECK(verified_law({kLoop, 0, 3, 0, kTest | 1, 1, kNegate, kNext, 0, 7, 0}) == Refusal::kNone);
  // a jump out of one loop into the next loop
  CHECK(verified_law({kLoop, 0, 3, 0, kTest | 1, 8, kNext, 0, 6, 0, kLoop, 0, 3, 0, kNext, 0, 4, 0}) == Refusal::kJump);
}

TEST(loops_must_be_closed) {
  CHECK(verified_law({kLoop, 0, 1, 0, kNext, 0, 4, 0}) == Refusal::kNone);
  // the loop runs zero times
  CHECK(verified_law({kLoop, 0, 0, 0, kNext, 0, 4, 0}) == Refusal::kLoop);
  // the jump distance is wrong
  CHECK(verified_law({kLoop, 0, 1, 0, kNext, 0, 3, 0}) == Refusal::kLoop);
  CHECK(verified_law({kLoop, 0, 1, 0, kNext, 0, 8, 0}) == Refusal::kLoop);
  // the counter is a different one
  CHECK(verified_law({kLoop, 0, 1, 0, kNext, 1, 4, 0}) == Refusal::kLoop);
  CHECK(verified_law({kNext, 0, 4, 0}) == Refusal::kLoop);                               // no loop is open
  // the loop is never closed
  CHECK(verified_law({kLoop, 0, 1, 0}) == Refusal::kLoop);
  CHECK(verified_law({kLoop, kMostCounters - 1, 1, 0, kNext, kMostCounters - 1, 4, 0}) == Refusal::kNone);
  CHECK(verified_law({kLoop, kMostCounters, 1, 0, kNext, kMostCounters, 4, 0}) == Refusal::kLoop);
}

TEST(inner_loops_need_lower_counters) {
  for (uint8_t outer = 0; outer < 3; outer++)
    for (uint8_t inner = 0; inner < 3; inner++)
      CHECK(verified_law({kLoop, outer, 2, 0, kLoop, inner, 2, 0, kNext, inner, 4, 0, kNext, outer, 12, 0}) ==
            (inner < outer ? Refusal::kNone : Refusal::kLoop));
  // the same, with the inner loop in a called subroutine
  const auto called = [](uint8_t outer) {
    return verified({kSubroutine, kLoop, 1, 2, 0, kNext, 1, 4, 0, kReturn, kMain, kLoop, outer, 2, 0, kCall, 0, 0,
                     kNext, outer, 7, 0, kReturn});
  };
  CHECK(called(2) == Refusal::kNone);
  CHECK(called(1) == Refusal::kLoop);
}

TEST(calls_must_lead_to_earlier_subroutines) {
  CHECK(verified({kSubroutine, kReturn, kMain, kCall, 0, 0, kReturn}) == Refusal::kNone);
  CHECK(verified({kSubroutine, kReturn, kMain, kCall, 1, 0, kReturn}) == Refusal::kCall);
  // this calls MAIN
  CHECK(verified({kSubroutine, kReturn, kMain, kCall, 2, 0, kReturn}) == Refusal::kCall);
  CHECK(verified({kSubroutine, kReturn, kMain, kCall, 0, 1, kReturn}) == Refusal::kCall);
  // this calls itself
  CHECK(verified({kSubroutine, kCall, 0, 0, kReturn, kMain, kReturn}) == Refusal::kCall);
}

TEST(call_depth_and_number_of_subroutines_are_limited) {
  for (uint16_t depth : {kMostCalls, uint16_t(kMostCalls + 1)}) {
    Bytes bytes{kSubroutine, kReturn};
    for (uint8_t i = 1; i < depth; i++) {
      const uint8_t last = i == 1 ? 0 : static_cast<uint8_t>(2 + 5 * (i - 2));
      bytes.insert(bytes.end(), {kSubroutine, kCall, last, 0, kReturn});
    }
    const uint8_t last = static_cast<uint8_t>(2 + 5 * (depth - 2));
    bytes.insert(bytes.end(), {kMain, kCall, last, 0, kReturn});
    CHECK(verified(bytes) == (depth == kMostCalls ? Refusal::kNone : Refusal::kCall));
  }
  for (uint16_t count : {kMostSubroutines, uint16_t(kMostSubroutines + 1)}) {
    Bytes bytes;
    for (uint8_t i = 0; i < count; i++) bytes.insert(bytes.end(), {kSubroutine, kReturn});
    bytes.insert(bytes.end(), {kMain, kReturn});
    CHECK(verified(bytes) == (count == kMostSubroutines ? Refusal::kNone : Refusal::kCall));
  }
}

TEST(sections_must_end_with_return) {
  CHECK(verified({}) == Refusal::kEnd);
  CHECK(verified({kMain}) == Refusal::kEnd);
  CHECK(verified({kMain, kNegate}) == Refusal::kEnd);
  CHECK(verified({kSubroutine, kReturn}) == Refusal::kEnd);  // there is no MAIN
  CHECK(verified({kSubroutine, kMain, kReturn}) == Refusal::kEnd);
  CHECK(verified({kMain, kReturn, kNegate}) == Refusal::kNone);  // the last instruction is unreachable
  CHECK(verified({kMain, kTest | 1, 1, kReturn, kNegate}) == Refusal::kEnd);
  CHECK(verified({kMain, kTest | 1, 1, kReturn, kReturn}) == Refusal::kNone);
}

TEST(given_numbers_must_be_finite) {
  CHECK(verified(law({}), 3.4e38f) == Refusal::kNone);
  CHECK(verified(law({}), INFINITY) == Refusal::kConstant);
  CHECK(verified(law({}), -INFINITY) == Refusal::kConstant);
  CHECK(verified(law({}), NAN) == Refusal::kConstant);
}

TEST(code_beyond_the_cycle_counter_is_too_slow) {
  const uint16_t body = most(kPower) + most(kNext);
  const uint16_t times = static_cast<uint16_t>((kMostCycles - most(kLoop) - most(kReturn)) / body);
  for (uint16_t n : {times, uint16_t(times + 1), uint16_t(65535)}) {
    const Refusal found = verified_law({kLoop, 0, uint8_t(n & 255), uint8_t(n >> 8), kPower, 0, kNext, 0, 6, 0});
    CHECK(found == (n == times ? Refusal::kNone : Refusal::kTooSlow));
  }
}

TEST(the_bound_is_the_cost_of_the_longest_path) {
  CHECK(verified_law({kTest | 1, 2, kPower, 0, kNegate}) == Refusal::kNone);
  CHECK(cycles == uint32_t(most(kTest) + most(kPower) + most(kNegate) + most(kReturn)));
  // a call also costs the cycles of its callee
  CHECK(verified({kSubroutine, kSin, kReturn, kMain, kCall, 0, 0, kReturn}) == Refusal::kNone);
  CHECK(cycles == uint32_t(most(kCall) + most(kSin) + 2 * most(kReturn)));
  // a loop costs its body times its count; before an early exit all but one iteration are complete
  CHECK(verified_law({kLoop, 0, 10, 0, kSin, kTest | 1, 6, kCos, kNegate, kNext, 0, 9, 0}) == Refusal::kNone);
  const uint32_t body = most(kSin) + most(kTest) + most(kCos) + most(kNegate) + most(kNext);
  CHECK(cycles == most(kLoop) + 10 * body + most(kReturn));
}

TEST(a_return_in_a_loop_costs_the_earlier_iterations) {
  // LOOP 10: TEST to +2; SIN; RETURN; NEGATE; NEXT
  CHECK(verified_law({kLoop, 0, 10, 0, kTest | 1, 2, kSin, kReturn, kNegate, kNext, 0, 9, 0}) == Refusal::kNone);
  const uint32_t round = most(kTest) + most(kNegate) + most(kNext);
  CHECK(cycles == most(kLoop) + 9 * round + most(kTest) + most(kSin) + most(kReturn));
}

TEST(loops_run_the_given_number_of_times) {
  CHECK(verified_law({kLoad, kState, kLoop, 1, 3, 0, kLoop, 0, 4, 0, kAdd, kState, kNext, 0, 6, 0, kNext, 1, 14, 0}) ==
        Refusal::kNone);
  CHECK(run(0.0f, 0.0f) == 13.0f);
}

TEST(calls_return_to_where_they_came_from) {
  CHECK(verified({kSubroutine, kAdd, kConstant, kReturn,                     // computes a + 5
                  kSubroutine, kCall, 0, 0, kMultiply, 0, kReturn,           // computes (a + 5) x
                  kMain, kLoad, 1, kCall, 4, 0, kCall, 0, 0, kReturn}) == Refusal::kNone);
  CHECK(run(2.0f, 1.0f) == 17.0f);
}

TEST(a_fault_ends_the_law_at_any_call_depth) {
  const auto force = [](std::initializer_list<uint8_t> body, float x) {
    Bytes bytes{kSubroutine};
    bytes.insert(bytes.end(), body);
    bytes.insert(bytes.end(), {kReturn, kSubroutine, kCall, 0, 0, kReturn, kMain, kLoad, kState, kCall,
                               static_cast<uint8_t>(body.size() + 2), 0, kReturn});
    CHECK(verified(bytes) == Refusal::kNone);
    return run(x, 0.0f);
  };
  for (uint8_t opcode : {kDivide, kFloorDivide, kModulo, kRemainder}) {
    CHECK(std::isfinite(force({opcode, 0}, 0.5f)));
    CHECK(std::isnan(force({opcode, 0}, 0.0f)));
    CHECK(std::isnan(force({opcode, 0}, -0.0f)));
    CHECK(std::isnan(force({opcode, 0}, 1e-40f)));
  }
  CHECK(force({kLoad, 0, kDivideInto, kConstant}, 2.0f) == 2.5f);
  CHECK(std::isnan(force({kLoad, 0, kDivideInto, kConstant}, 0.0f)));
  for (uint8_t opcode : {kLoadAt, kStoreAt}) {
    for (float inside : {0.0f, -0.0f, 0.9f, 1.0f, 1.99f, 1e-40f})
      CHECK(std::isfinite(force({opcode, 0, kTemporary, 2}, inside)));
    for (float outside : {2.0f, -0.1f, -1e-40f, 255.0f, 256.0f, 1e30f, NAN, INFINITY, -INFINITY})
      CHECK(std::isnan(force({opcode, 0, kTemporary, 2}, outside)));
  }
}

TEST(tables_are_read_and_written_by_index) {
  CHECK(verified_law({kLoad, 1, kStoreAt, 0, kTemporary, 3, kLoad, kTemporary + 2}) == Refusal::kNone);
  CHECK(run(2.5f, 7.0f) == 7.0f);
  CHECK(verified_law({kLoadAt, 0, kState, 2}) == Refusal::kNone);
  CHECK(run(1.0f, 0.0f) == 5.0f);
}

TEST(outcomes_of_comparisons) {
  const auto outcome = [](float a, float b) {
    uint8_t found = 0;
    for (uint8_t mask : {1, 2, 4, 8}) {
      CHECK(verified_law({kLoad, 0, uint8_t(kCompare | mask), 1, 3, kLoad, kTemporary, kReturn, kLoad, kState}) ==
            Refusal::kNone);
      if (run(a, b) == 1.0f) found |= mask;
      if (b != 0.0f) continue;
      CHECK(verified_law({kLoad, 0, uint8_t(kTest | mask), 3, kLoad, kTemporary, kReturn, kLoad, kState}) ==
            Refusal::kNone);
      CHECK((run(a, b) == 1.0f) == ((found & mask) != 0));
    }
    return found;
  };
  const float all[] = {-INFINITY, -3.0f, -1e-40f, -0.0f, 0.0f, 1e-40f, 3.0f, INFINITY};
  for (float a : all) {
    for (float b : all) CHECK(outcome(a, b) == (a < b ? 1 : a == b ? 2 : 4));
    CHECK(outcome(a, NAN) == 8);
    CHECK(outcome(NAN, a) == 8);
  }
}

TEST(reading_the_velocity_is_detected) {
  CHECK(verified_law({kLoad, 0}) == Refusal::kNone && !program.reads_velocity);
  CHECK(verified_law({kLoad, 1}) == Refusal::kNone && program.reads_velocity);
  CHECK(verified_law({kCompare | 1, 1, 0}) == Refusal::kNone && program.reads_velocity);
  CHECK(verified_law({kLoadAt, 0, 0, 2}) == Refusal::kNone && program.reads_velocity);
  CHECK(verified_law({kLoadAt, 1, 2, 2}) == Refusal::kNone && program.reads_velocity);
  CHECK(verified_law({kLoadAt, 0, 2, 2}) == Refusal::kNone && !program.reads_velocity);
}
