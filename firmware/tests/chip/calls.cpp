// The program begins, then waits for calls.
int main() {
  __asm__ volatile("sleep");
  return 0;
}
