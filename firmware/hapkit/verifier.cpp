#include "functions.h"
#include "machine.h"

namespace machine {

Program program;

namespace {

constexpr uint16_t kSaturated = 65535;
static_assert(kMostCycles == kSaturated - 1, "costs are counted in 16 bits");
constexpr uint16_t kEnd = 65535;      // a jump target outside the section
constexpr uint16_t kNowhere = 65534;  // there is no jump
static_assert(kArena < kNowhere, "code may reach the places that mean others");

uint16_t sum(uint16_t a, uint16_t b) {
  const uint16_t total = a + b;
  return total < a ? kSaturated : total;
}

uint16_t product(uint16_t a, uint16_t b) {
  const uint32_t total = static_cast<uint32_t>(a) * b;
  return total < kSaturated ? static_cast<uint16_t>(total) : kSaturated;
}

uint16_t larger(uint16_t a, uint16_t b) { return a > b ? a : b; }

uint16_t word(const uint8_t* at) { return static_cast<uint16_t>(at[0] | at[1] << 8); }

Operation operation_of(uint8_t opcode) {
  if (opcode >= kMasked) opcode = kSingle + (opcode - kMasked) / kMasks;
  else if (opcode >= kSingle) return {kUnknown, 0};
  return opcode < sizeof kTable / sizeof *kTable ? flash::read(kTable + opcode) : Operation{kUnknown, 0};
}

// One forward pass over a law's code, which checks memory accesses, jumps and cycles. All jumps except those
// of NEXT lead forward.
class Verifier {
 public:
  explicit Verifier(const Shape& shape) : shape_(shape), code_(code(shape)) {}

  Refusal check();

  // After kNone, these return the offset of MAIN, the worst-case cycles, and whether the velocity is read.
  uint16_t entry() const { return section_; }
  uint16_t cycles() const { return worst_; }
  bool reads_velocity() const { return velocity_; }

 private:
  // A pending jump, or a return out of a loop.
  struct Way {
    uint16_t target;
    uint16_t cost;
    uint8_t depth;  // number of enclosing loops, without those that it leaves
  };
  // An open loop; costs inside it count from 0.
  struct Loop {
    uint16_t body;
    uint16_t times;
    uint16_t before;
    uint8_t free;  // number of free counters at its start
  };
  struct Subroutine {
    uint16_t at;
    uint16_t cost;
    uint8_t counters;  // counters below this number may be in use
    uint8_t calls;     // call depth
  };

  Refusal step();
  Refusal begin_section();
  Refusal end_section();
  Refusal arrive();
  Refusal call(uint16_t at);
  Refusal open_loop(uint8_t counter, uint16_t times);
  Refusal close_loop(uint8_t counter, uint16_t back);
  Refusal leave(uint16_t target);
  Refusal touch(uint8_t first, uint8_t count, bool written);

  const Shape& shape_;
  const uint8_t* code_;
  uint16_t at_ = 0;
  uint16_t next_ = 0;
  uint16_t section_ = 0;
  uint16_t cost_ = 0;
  uint16_t worst_ = 0;
  bool inside_ = false;  // true within a section
  bool alive_ = false;   // true while the code is reachable
  bool velocity_ = false;
  uint8_t counters_ = 0;
  uint8_t calls_ = 0;
  uint8_t depth_ = 0;
  uint8_t free_ = kMostCounters;  // the counters below this one are free
  Way* end_ = ways_;
  Subroutine* last_ = subroutines_;
  Way ways_[kMostJumps];
  Loop loops_[kMostCounters];
  Subroutine subroutines_[kMostSubroutines];
};

Refusal Verifier::check() {
  Refusal refusal = Refusal::kNone;
  while (refusal == Refusal::kNone && next_ < shape_.code) {
    at_ = next_;
    refusal = step();
  }
  if (refusal != Refusal::kNone) return refusal;
  if (!inside_ || code_[section_] != kMain) return Refusal::kEnd;
  refusal = end_section();
  return refusal == Refusal::kNone && worst_ == kSaturated ? Refusal::kTooSlow : refusal;
}

Refusal Verifier::step() {
  const uint8_t* const given = code_ + at_ + 1;
  const uint8_t opcode = code_[at_];
  const Operation operation = operation_of(opcode);
  const uint8_t size = operation.operands & kSizeOf;
  if (size == 0 || size > shape_.code - at_) return Refusal::kOperation;
  next_ = at_ + size;
  if (opcode == kSubroutine || opcode == kMain) return begin_section();
  if (!inside_) return Refusal::kOperation;
  Refusal refusal = arrive();
  if (refusal != Refusal::kNone) return refusal;
  cost_ = sum(cost_, operation.most);
  const uint8_t first = given[0];
  uint16_t distance = kNowhere;
  switch (operation.operands) {
    case kCounter: {
      const uint16_t number = word(given + 1);
      return opcode == kLoop ? open_loop(first, number) : close_loop(first, number);
    }
    case kSlot: return touch(first, 1, opcode == kStore);
    case kIndexed:
      refusal = touch(first, 1, false);
      return refusal != Refusal::kNone ? refusal : touch(given[1], given[2], opcode == kStoreAt);
    case kSlotNear:
      refusal = touch(first, 1, false);
      distance = given[1];
      break;
    case kFar:
      distance = word(given);
      if (opcode == kCall) return call(distance);
      break;
    case kNear: distance = first; break;
    default:
      if (opcode != kReturn) return Refusal::kNone;
  }
  if (refusal != Refusal::kNone) return refusal;
  uint16_t target = kEnd;
  if (opcode != kReturn) {
    if (distance >= shape_.code - next_) return Refusal::kJump;
    target = next_ + distance;
  }
  refusal = leave(target);
  if (opcode < kMasked) alive_ = false;
  return refusal;
}

Refusal Verifier::begin_section() {
  if (inside_) {
    if (code_[section_] == kMain) return Refusal::kOperation;
    const Refusal refusal = end_section();
    if (refusal != Refusal::kNone) return refusal;
    if (last_ == subroutines_ + kMostSubroutines) return Refusal::kCall;
    *last_++ = {section_, worst_, counters_, calls_};
  }
  section_ = at_;
  inside_ = alive_ = true;
  cost_ = worst_ = 0;
  counters_ = calls_ = 0;
  return Refusal::kNone;
}

Refusal Verifier::end_section() {
  if (depth_) return Refusal::kLoop;
  if (alive_) return Refusal::kEnd;
  while (end_ != ways_) {
    const Way& way = *--end_;
    if (way.target != kEnd) return Refusal::kJump;
    worst_ = larger(worst_, way.cost);
  }
  return Refusal::kNone;
}

// Join the jumps that lead here with the code above.
Refusal Verifier::arrive() {
  for (Way* way = ways_; way != end_;) {
    if (way->target > at_) {
      way++;
      continue;
    }
    if (way->target < at_ || way->depth != depth_) return Refusal::kJump;
    cost_ = alive_ ? larger(cost_, way->cost) : way->cost;
    alive_ = true;
    *way = *--end_;
  }
  return Refusal::kNone;
}

Refusal Verifier::call(uint16_t at) {
  const Subroutine* called = subroutines_;
  while (called != last_ && called->at != at) called++;
  if (called == last_ || called->calls >= kMostCalls) return Refusal::kCall;
  if (called->counters > free_) return Refusal::kLoop;
  cost_ = sum(cost_, called->cost);
  if (calls_ <= called->calls) calls_ = called->calls + 1;
  if (counters_ < called->counters) counters_ = called->counters;
  return Refusal::kNone;
}

Refusal Verifier::open_loop(uint8_t counter, uint16_t times) {
  if (times == 0 || counter >= free_) return Refusal::kLoop;
  if (counters_ <= counter) counters_ = counter + 1;
  loops_[depth_++] = {next_, times, cost_, free_};
  free_ = counter;
  cost_ = 0;
  return Refusal::kNone;
}

// When control leaves from inside the loop, at most times - 1 iterations are complete.
Refusal Verifier::close_loop(uint8_t counter, uint16_t back) {
  if (depth_ == 0) return Refusal::kLoop;
  const Loop& loop = loops_[--depth_];
  if (free_ != counter || back != next_ - loop.body) return Refusal::kLoop;
  free_ = loop.free;
  const uint16_t body = alive_ ? cost_ : 0;
  const uint16_t until_last = sum(loop.before, product(body, loop.times - 1));
  for (Way* way = ways_; way != end_; way++) {
    if (way->depth <= depth_) continue;
    way->depth = depth_;
    way->cost = sum(until_last, way->cost);
  }
  cost_ = sum(until_last, body);
  return Refusal::kNone;
}

Refusal Verifier::leave(uint16_t target) {
  if (!alive_) return Refusal::kNone;
  Way* way = ways_;
  while (way != end_ && (way->target != target || way->depth != depth_)) way++;
  if (way == end_) {
    if (end_++ == ways_ + kMostJumps) return Refusal::kJump;
    *way = {target, 0, depth_};
  }
  way->cost = larger(way->cost, cost_);
  return Refusal::kNone;
}

// Only states and temporaries are writable.
Refusal Verifier::touch(uint8_t first, uint8_t count, bool written) {
  const uint8_t last = first + count - 1;
  if (last < first || last >= shape_.slots) return Refusal::kSlot;
  if (first <= kVelocity && last >= kVelocity) velocity_ = true;
  const uint8_t constants = kFirstGiven + shape_.states, others = kFirstGiven + shape_.given;
  if (!written || first >= others) return Refusal::kNone;
  return first >= kFirstGiven && (last < constants || constants == others) ? Refusal::kNone : Refusal::kSlot;
}

}  // namespace

bool fits(const Shape& shape) {
  const uint32_t taken = sizeof(float) * shape.slots + static_cast<uint32_t>(shape.code) + kRamps * kRamp;
  return shape.states <= shape.given && kFirstGiven + shape.given <= shape.slots && taken <= kArena;
}

Refusal verify(const Shape& shape, uint32_t* cycles) {
  if (!fits(shape)) return Refusal::kTooLarge;
  for (uint8_t i = 0; i < shape.given; i++)
    if (!functions::is_finite(slots()[kFirstGiven + i])) return Refusal::kConstant;
  Verifier verifier(shape);
  const Refusal refusal = verifier.check();
  *cycles = verifier.cycles();
  program.code = code(shape);
  program.main = program.code + verifier.entry();
  program.reads_velocity = verifier.reads_velocity();
  return refusal;
}

}  // namespace machine
