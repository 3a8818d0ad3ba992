#include "loading.h"

#include "board.h"
#include "crc.h"

bool Loading::announce(const protocol::Law& law) {
  if (law.generation == law_.generation) return false;
  law_ = law;
  received_ = 0;
  refusal_ = look();
  phase_ = refusal_ == machine::Refusal::kNone ? kAnnounced : kNone;
  return true;
}

bool Loading::begin() {
  if (phase_ != kAnnounced) return false;
  phase_ = kComing;
  crc_ = crc::kStart;
  return advance();
}

bool Loading::take(const protocol::Piece& piece) {
  if (phase_ != kComing || piece.generation != law_.generation || piece.at != received_) return false;
  // The initial values follow the slots of position and velocity; the code follows all slots.
  const uint16_t values = 4 * law_.given;
  const uint16_t gap = 4 * (law_.slots - law_.given - machine::kFirstGiven);
  for (uint8_t i = 0; i < protocol::kPiece && received_ < size(); ++i, ++received_) {
    machine::arena[4 * machine::kFirstGiven + received_ + (received_ < values ? 0 : gap)] = piece.data[i];
    crc_ = crc::update(crc_, piece.data[i]);
  }
  return advance();
}

// After all bytes have arrived, damaged code is requested again from the start.
bool Loading::advance() {
  if (received_ < size()) return false;
  if (crc_ != law_.check) {
    received_ = 0;
    crc_ = crc::kStart;
    return false;
  }
  phase_ = kNone;
  for (uint8_t i = machine::kFirstGiven + law_.given; i < law_.slots; ++i) machine::slots()[i] = 0.0f;
  refusal_ = check();
  return refusal_ == machine::Refusal::kNone;
}

// These checks need only the header.
machine::Refusal Loading::look() const {
  estimator::Design made;
  if (!estimator::design(loop(), 1.0f, 1.0f, &made)) return machine::Refusal::kRate;
  return machine::fits(shape()) ? machine::Refusal::kNone : machine::Refusal::kTooLarge;
}

machine::Refusal Loading::check() const {
  uint32_t cycles;
  const machine::Refusal found = machine::verify(shape(), &cycles);
  if (found != machine::Refusal::kNone) return found;
  constexpr uint8_t kCyclesPerTick = board::kCpu / 1000 / board::kTicksPerMs;
  const uint16_t period = law_.period * kCyclesPerTick;
  return cycles + machine::kRestAtMost > period ? machine::Refusal::kTooSlow : machine::Refusal::kNone;
}
