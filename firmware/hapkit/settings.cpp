#include "settings.h"

#include <stddef.h>
#include <string.h>

#include "board.h"
#include "crc.h"
#include "eeprom.h"
#include "limits.h"
#include "motor.h"
#include "profile.h"
#include "sensor.h"

#ifndef __AVR__
#define memcpy_P memcpy
#endif

namespace settings {
namespace {

// The EEPROM has two slots. A save writes to the unused slot: first its mark is erased, then the block is
// written, then the mark; finally the mark of the other slot is erased. So at every instant there is a
// complete block, old or new, or there was never one. A mark with an invalid block means damage. Byte 0 is
// not used, because a failing supply damages it first. place_of is a function, because an array would take RAM.
constexpr uint16_t place_of(uint8_t which) { return 16 + 256 * which; }
constexpr uint8_t kNone = 2;
constexpr uint8_t kMark = 1;  // the version of this layout
constexpr uint8_t kSequenceAt = 1;
constexpr uint8_t kBoardAt = 2;
constexpr uint8_t kCrcAt = kBoardAt + protocol::Board::kSize;
constexpr uint8_t kBlock = kCrcAt + 2;
static_assert(kMark != eeprom::kErased, "an erased mark means nothing there");

protocol::Board in_force = {
    profile::kNumber, protocol::kPinsD5D8, protocol::kSensorMagnetoresistive, protocol::kMotorMapSquare,
    1, 1, profile::kCountsPerFlip, 0, profile::kQuantum, profile::kMaxForce, profile::kMotorConstant,
    profile::kHandleRadius, profile::kPulleyRadius, profile::kSectorRadius, profile::kMass,
    profile::kViscous, profile::kCoulomb, 0, {32, 64, 96, 128, 159, 191, 223, 255}, "Hapkit"};
uint8_t from = protocol::kOriginDefault;

uint8_t place = kNone;  // the slot in use
uint8_t sequence = 0;   // sequence number of the block in use
uint8_t target = 0;     // slot of the save in progress
uint8_t step = 0;       // the next step of this save; 0 if no save is in progress
uint16_t crc_word = 0;

// --- validation
bool has_pins_free(const protocol::Board& kit) {
  // The encoder needs D3, and the AS5048A needs D11 to D13, which the other board uses for its motors.
  return kit.pins == protocol::kPinsD5D8 ||
         (kit.pins == protocol::kPinsD3D12 && kit.sensor == protocol::kSensorMagnetoresistive);
}

bool counts_fit(const protocol::Board& kit) {
  const uint16_t counts = kit.counts_per_flip;
  if (kit.sensor == protocol::kSensorAs5048A) return counts == limits::kAs5048ACounts;
  if (kit.sensor == protocol::kSensorQuadrature) return counts >= limits::kFewestSteps;
  return kit.sensor == protocol::kSensorMagnetoresistive && counts >= limits::kFewestCounts &&
         counts <= limits::kMostCounts;
}

bool never_falls(const uint8_t* table) {
  for (uint8_t i = 1; i < sizeof(protocol::Board::table); ++i) {
    if (table[i] < table[i - 1]) return false;
  }
  return table[sizeof(protocol::Board::table) - 1] == 255;
}

bool is_text(const char* label) {
  bool ended = false;
  for (uint8_t i = 0; i < sizeof(protocol::Board::label); ++i) {
    const char c = label[i];
    if (c == 0) ended = true;
    if (c != 0 && (ended || c < ' ' || c > '~')) return false;
  }
  return true;
}

bool is_sign(int8_t sign) { return sign == 1 || sign == -1; }

bool numbers_fit(const protocol::Board& kit) {
  constexpr uint8_t kCount = sizeof(limits::kNumbers) / sizeof(limits::Range);
  constexpr uint8_t kFirst = offsetof(protocol::Board, quantum);
  static_assert(offsetof(protocol::Board, coulomb) == kFirst + (kCount - 1) * sizeof(float), "a number has no range");
  for (uint8_t i = 0; i < kCount; ++i) {
    float value;
    memcpy(&value, reinterpret_cast<const uint8_t*>(&kit) + kFirst + i * sizeof(value), sizeof(value));
    limits::Range range;
    memcpy_P(&range, &limits::kNumbers[i], sizeof(range));
    if (!range.holds(value)) return false;
  }
  return true;
}

bool is_a_kit(const protocol::Board& kit) {
  return has_pins_free(kit) && counts_fit(kit) && kit.motor_map <= protocol::kMotorMapTable &&
         is_sign(kit.direction) && is_sign(kit.sense) && kit.zero >= -limits::kLargestZero &&
         kit.zero <= limits::kLargestZero && numbers_fit(kit) && kit.dead_band <= limits::kLargestDeadBand &&
         never_falls(kit.table) && is_text(kit.label);
}

// --- EEPROM
uint8_t mark_of(uint8_t which) { return eeprom::read(place_of(which)); }

// Read one slot; return false if it has no complete block.
bool read_block(uint8_t which, protocol::Board* kit) {
  uint8_t* bytes = reinterpret_cast<uint8_t*>(kit);
  uint16_t crc = crc::kStart;
  for (uint8_t i = 0; i < kBlock; ++i) {
    const uint8_t byte = eeprom::read(place_of(which) + i);
    crc = crc::update(crc, byte);
    if (i >= kBoardAt && i < kCrcAt) bytes[i - kBoardAt] = byte;
  }
  return mark_of(which) == kMark && crc == 0 && is_a_kit(*kit);
}

// Use a slot's block if it is complete and newer than the one found so far.
void consider(uint8_t which) {
  protocol::Board kit;
  if (!read_block(which, &kit)) {
    if (place == kNone && mark_of(which) != eeprom::kErased) from = protocol::kOriginDamaged;
    return;
  }
  const uint8_t number = eeprom::read(place_of(which) + kSequenceAt);
  if (place != kNone && static_cast<int8_t>(number - sequence) < 0) return;
  in_force = kit;
  from = protocol::kOriginStored;
  place = which;
  sequence = number;
}

uint8_t block_byte(uint8_t at) {
  if (at == kSequenceAt) return sequence + 1;
  if (at == kCrcAt) return crc_word >> 8;
  if (at == kCrcAt + 1) return static_cast<uint8_t>(crc_word);
  return reinterpret_cast<const uint8_t*>(&in_force)[at - kBoardAt];
}

uint16_t crc_of_block() {
  uint16_t crc = crc::update(crc::kStart, kMark);
  for (uint8_t i = kSequenceAt; i < kCrcAt; ++i) crc = crc::update(crc, block_byte(i));
  return crc;
}

// Return true if the settings equal those of the complete slot in use. They are compared byte by byte,
// because a copy would take too much stack.
bool is_kept() {
  if (place == kNone || mark_of(place) != kMark) return false;
  for (uint8_t i = kBoardAt; i < kCrcAt; ++i) {
    if (eeprom::read(place_of(place) + i) != block_byte(i)) return false;
  }
  return true;
}

// Steps of a save: erase the mark; write the bytes after the mark (2 .. kBlock); write the mark; erase the
// mark of the other slot.
constexpr uint8_t kEraseMark = 1;
constexpr uint8_t kWriteMark = kBlock + 1;
constexpr uint8_t kEraseOther = kBlock + 2;

// Begin to write one byte; return false if the byte is unchanged.
bool write(uint16_t at, uint8_t byte) {
  if (eeprom::read(at) == byte) return false;
  eeprom::write(at, byte);
  return true;
}

bool carry_out(uint8_t which) {
  if (which == kEraseMark) return write(place_of(target), eeprom::kErased);
  if (which == kWriteMark) return write(place_of(target), kMark);
  if (which == kEraseOther) return write(place_of(1 - target), eeprom::kErased);
  return write(place_of(target) + which - 1, block_byte(which - 1));
}

void finish() {
  step = 0;
  place = target;
  ++sequence;
  from = protocol::kOriginStored;
}

}  // namespace

const protocol::Board& now() { return in_force; }

uint8_t origin() { return from; }

void load() {
  place = kNone;
  step = 0;
  from = protocol::kOriginDefault;
  consider(0);
  consider(1);
  board::hold(true);
  motor::set(in_force);
  sensor::start(in_force);
  board::configure(in_force);
  board::hold(false);
}

bool accept(const protocol::Board& wanted) {
  if (!is_a_kit(wanted)) return false;
  if (memcmp(&wanted, &in_force, sizeof(wanted)) != 0) from = protocol::kOriginUnsaved;
  step = 0;  // discard a save that is not finished
  board::hold(true);
  in_force = wanted;
  motor::set(in_force);
  sensor::change(in_force);
  board::configure(in_force);
  board::hold(false);
  return true;
}

void save() {
  if (is_kept()) {
    from = protocol::kOriginStored;
    return;
  }
  target = place == 0 ? 1 : 0;
  crc_word = crc_of_block();
  step = kEraseMark;
}

bool saving() { return step != 0; }

void poll() {
  while (step && eeprom::ready()) {
    if (step > kEraseOther) return finish();
    if (carry_out(step++)) return;
  }
}

}  // namespace settings
