// Everything that a list-minded embedder trips over: ; [a;b] \n \\ $X ${X} "quoted" @X@
int odd[2] = int[2](1, 2); // ]

int last;