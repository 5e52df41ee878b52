// Numbers that every shader means alike.
const float PI = 3.14159265358979;
const float HALF_PI = 1.57079632679490;
const float TWO_PI = 6.28318530717959;
