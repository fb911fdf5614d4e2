/* What the example uses of Arduino's library, declared, so that a compiler can read it as a sketch. */
#pragma once

struct Port {
  void begin(unsigned long rate);
  void print(char text);
  void print(unsigned long number);
  void println(const char* text);
  void println(unsigned long number);
  void println(double number, int digits);
};
extern Port Serial;
enum { A0 = 14 };
int analogRead(int pin);
