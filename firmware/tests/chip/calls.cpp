// Start the program, then wait for calls.
int main() {
  __asm__ volatile("sleep");
  return 0;
}
