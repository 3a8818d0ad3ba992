#include "verifier.h"

namespace machine {
namespace {

constexpr uint16_t kSaturated = kMostCycles + 1;
constexpr uint16_t kEnd = 65535;  // in place of a target: the section's end, where no code can be
static_assert(kArena < kEnd, "code may reach the place that means its end");

uint16_t sum(uint16_t a, uint32_t b) {
  const uint32_t total = a + b;
  return total < kSaturated ? static_cast<uint16_t>(total) : kSaturated;
}

uint16_t larger(uint16_t a, uint16_t b) { return a > b ? a : b; }

uint16_t word(const uint8_t* at) { return static_cast<uint16_t>(at[0] | at[1] << 8); }

Operation operation_of(uint8_t opcode) {
  if (opcode < kSingle) return flash::read(kTable + opcode);
  const uint8_t row = static_cast<uint8_t>(opcode - kMasked) >> 4;
  if (opcode < kMasked || row >= sizeof kTable / sizeof *kTable - kSingle) return {kUnknown, 0};
  return flash::read(kTable + kSingle + row);
}

uint8_t size_of(Operands operands) {
  switch (operands) {
    case kSlot:
    case kNear: return 2;
    case kSlotNear:
    case kFar: return 3;
    case kIndexed:
    case kCounter: return 4;
    default: return 1;
  }
}

}  // namespace

void Verifier::spend(uint16_t cycles) { cost_ = sum(cost_, cycles); }

Refusal Verifier::check() {
  while (next_ < shape_.code) {
    at_ = next_;
    const Refusal refusal = step();
    if (refusal != Refusal::kNone) return refusal;
  }
  at_ = next_;
  if (!inside_ || code_[section_] != kMain) return Refusal::kEnd;
  const Refusal refusal = end_section();
  if (refusal != Refusal::kNone) return refusal;
  return worst_ == kSaturated ? Refusal::kTooSlow : Refusal::kNone;
}

Refusal Verifier::step() {
  const uint8_t opcode = code_[at_];
  const Operation operation = operation_of(opcode);
  const uint8_t size = size_of(operation.operands);
  if (operation.operands == kUnknown || size > shape_.code - at_) return Refusal::kOperation;
  next_ = at_ + size;
  if (opcode == kSubroutine || opcode == kMain) return begin_section();
  if (!inside_) return Refusal::kOperation;
  Refusal refusal = arrive();
  if (refusal != Refusal::kNone) return refusal;
  spend(operation.most);
  const uint8_t* const given = code_ + at_ + 1;
  switch (opcode) {
    case kReturn:
      refusal = leave(kEnd);
      alive_ = false;
      return refusal;
    case kCall: return call(word(given));
    case kLoop: return open_loop(given[0], word(given + 1));
    case kNext: return close_loop(given[0], word(given + 1));
    case kStore: return range(given[0], 1, true);
    case kLoadAt:
    case kStoreAt: return is_slot(given[0]) ? range(given[1], given[2], opcode == kStoreAt) : Refusal::kSlot;
    case kJump:
      refusal = jump(given[0]);
      alive_ = false;
      return refusal;
    case kFarJump:
      refusal = jump(word(given));
      alive_ = false;
      return refusal;
    default: break;
  }
  if (operation.operands == kNone) return Refusal::kNone;
  if (operation.operands == kNear) return jump(given[0]);
  if (!is_slot(given[0])) return Refusal::kSlot;
  return operation.operands == kSlotNear ? jump(given[1]) : Refusal::kNone;
}

// States and temporaries may be written to.
Refusal Verifier::range(uint8_t first, uint8_t count, bool written) const {
  if (count == 0 || first + count > shape_.slots) return Refusal::kSlot;
  const uint8_t constants = kFirstGiven + shape_.states, others = kFirstGiven + shape_.given;
  if (!written || first >= others) return Refusal::kNone;
  const bool inside = first >= kFirstGiven && (first + count <= constants || constants == others);
  return inside ? Refusal::kNone : Refusal::kSlot;
}

Refusal Verifier::begin_section() {
  if (inside_) {
    if (code_[section_] == kMain) return Refusal::kOperation;
    const Refusal refusal = end_section();
    if (refusal != Refusal::kNone) return refusal;
    if (subroutines_ == kMostSubroutines) return Refusal::kCall;
    subroutine_[subroutines_++] = {section_, worst_, counters_, calls_};
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
  for (; ways_; ways_--) {
    if (way_[ways_ - 1].target != kEnd) return Refusal::kJump;
    worst_ = larger(worst_, way_[ways_ - 1].cost);
  }
  return Refusal::kNone;
}

Refusal Verifier::call(uint16_t at) {
  for (uint8_t i = 0; i < subroutines_; i++) {
    const Subroutine& called = subroutine_[i];
    if (called.at != at) continue;
    if (called.calls >= kMostCalls) return Refusal::kCall;
    if (called.counters > (depth_ ? loop_[depth_ - 1].counter : kMostCounters)) return Refusal::kLoop;
    spend(called.cost);
    if (calls_ <= called.calls) calls_ = called.calls + 1;
    if (counters_ < called.counters) counters_ = called.counters;
    return Refusal::kNone;
  }
  return Refusal::kCall;
}

Refusal Verifier::open_loop(uint8_t counter, uint16_t times) {
  if (times == 0 || counter >= (depth_ ? loop_[depth_ - 1].counter : kMostCounters)) return Refusal::kLoop;
  if (counters_ <= counter) counters_ = counter + 1;
  loop_[depth_++] = {next_, times, cost_, counter};
  cost_ = 0;
  return Refusal::kNone;
}

// The body has run at most so many times less one when something in it leads out.
Refusal Verifier::close_loop(uint8_t counter, uint16_t back) {
  if (depth_ == 0) return Refusal::kLoop;
  const Loop& loop = loop_[--depth_];
  if (loop.counter != counter || back != next_ - loop.body) return Refusal::kLoop;
  const uint32_t body = alive_ ? cost_ : 0;
  const uint16_t until_last = sum(loop.before, body * (loop.times - 1u));
  for (uint8_t i = 0; i < ways_; i++) {
    if (way_[i].depth <= depth_) continue;
    way_[i].depth = depth_;
    way_[i].cost = sum(until_last, way_[i].cost);
  }
  cost_ = sum(until_last, body);
  return Refusal::kNone;
}

// What jumps here joins what comes from above.
Refusal Verifier::arrive() {
  for (uint8_t i = 0; i < ways_;) {
    if (way_[i].target > at_) {
      i++;
      continue;
    }
    if (way_[i].target < at_ || way_[i].depth != depth_) return Refusal::kJump;
    cost_ = alive_ ? larger(cost_, way_[i].cost) : way_[i].cost;
    alive_ = true;
    way_[i] = way_[--ways_];
  }
  return Refusal::kNone;
}

Refusal Verifier::jump(uint16_t distance) {
  if (distance >= shape_.code - next_) return Refusal::kJump;
  return leave(next_ + distance);
}

Refusal Verifier::leave(uint16_t target) {
  if (!alive_) return Refusal::kNone;
  for (uint8_t i = 0; i < ways_; i++) {
    if (way_[i].target != target || way_[i].depth != depth_) continue;
    way_[i].cost = larger(way_[i].cost, cost_);
    return Refusal::kNone;
  }
  if (ways_ == kMostJumps) return Refusal::kJump;
  way_[ways_++] = {target, cost_, depth_};
  return Refusal::kNone;
}

}  // namespace machine
